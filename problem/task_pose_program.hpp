#pragma once

#include <modsearch/kinematics/simultaneous_ik.hpp>
#include <modsearch/problem/pose_program.hpp>
#include <modsearch/problem/robot_problem.hpp>

namespace modsearch {

/// The pose program of a robot problem: simultaneous inverse kinematics for the goals of its task.
class TaskPoseProgram final : public PoseProgram {
 public:
  /// Whether the task's goals are poses to visit that simultaneous inverse kinematics covers. Trajectories are not:
  /// their poses are linked.
  [[nodiscard]] static bool covers(const Task& task);

  /// `problem` must outlive it. Throws std::invalid_argument for a task that is not covered, and for types that do not
  /// fit together.
  TaskPoseProgram(const RobotProblem& problem, std::span<const int> types);

  [[nodiscard]] const Eigen::VectorXd& lower() const override { return ik_.lower(); }
  [[nodiscard]] const Eigen::VectorXd& upper() const override { return ik_.upper(); }
  [[nodiscard]] bool asks_for_orientation() const override;
  [[nodiscard]] bool generic() override;
  Outcome solve(int n_starts, const Start& start, const Arrival& arrival) override;
  [[nodiscard]] Design design(const Eigen::VectorXd& v) const override;
  [[nodiscard]] Witness witness(const Eigen::VectorXd& v) const override;

 private:
  const RobotProblem& problem_;
  std::vector<int> types_;
  std::shared_ptr<const Chain> chain_;
  Eigen::Index n_goals_;
  SimultaneousIk ik_;
};

}  // namespace modsearch
