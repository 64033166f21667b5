#pragma once

#include <memory>
#include <modsearch/problem/robot_problem.hpp>
#include <modsearch/problem/row_sink.hpp>

namespace modsearch {

/// The smooth program of a type sequence of a robot problem: least mass over (x, q per goal) such that every goal's
/// region holds, bodies keep clear of obstacles (and of each other, where the level asks for it), within all limits.
///
/// Tolerances that are a ball about the nominal (r_sph, r_cyl, Theta_R from 0) become vectors of rows within a ball,
/// which stay smooth at the nominal; all others become rows within intervals. One clearance row per goal and pair of
/// shapes that do not move. Where the task limits torques, one row per goal and joint with a peak torque: its static
/// torque. Between neighbouring knots of a trajectory one row per joint: as far as the joint may move on the way.
class TaskProgram final : public SmoothProgram {
 public:
  /// `problem` must outlive the program.
  TaskProgram(const RobotProblem& problem, std::span<const int> types, const Relaxation& relaxation);
  ~TaskProgram() override;

  /// Parameters from a Halton sequence (the first: the middle of their intervals), joints by inverse kinematics for
  /// them.
  [[nodiscard]] Eigen::VectorXd start(int index) override;
  [[nodiscard]] Design design(const Eigen::VectorXd& v) const override;

 private:
  class Sink;
  struct GoalRows;
  struct TaskRow {
    RowSink::Row row;
  };

  void do_evaluate(const Eigen::VectorXd& v, Values& values) override;
  [[nodiscard]] Eigen::MatrixXd do_hessian(const Eigen::VectorXd& v, double objective_factor,
                                           const Eigen::VectorXd& multipliers) override;

  void add_row(double lower, double upper);
  void add_ball(int count, double radius);
  void add_goal(int index, const Goal& goal, double margin);
  void add_clearances(const Relaxation& relaxation);
  void add_torques(const Relaxation& relaxation);
  void add_trajectories();
  [[nodiscard]] Eigen::Index q_at(int goal) const { return n_x_ + static_cast<Eigen::Index>(goal) * n_q_; }
  void goal_values(int goal, Values& values) const;
  void clearance_values(int goal, Values& values) const;
  void torque_values(int goal, Values& values) const;
  void trajectory_values(const Eigen::VectorXd& v, Values& values) const;
  /// Adds n_W . d p_W / d v to a clearance row, where p_W is a point of `geometry` at `goal`; `shape_counts`: the point
  /// is a witness on the surface, which moves as the shape grows.
  void add_clearance_gradient(Eigen::Index row, int goal, int geometry, const Eigen::Vector3d& p_W,
                              const Eigen::Vector3d& n_W, bool shape_counts, Values& values) const;

  const RobotProblem& problem_;
  std::vector<int> types_;
  std::shared_ptr<const Chain> kept_;
  const Chain& chain_;
  Arm arm_;
  Posture posture_;
  Eigen::Index n_x_ = 0;
  Eigen::Index n_q_ = 0;
  Eigen::VectorXd mass_gradient_;
  std::vector<GoalRows> goal_rows_;
  bool obstacle_rows_ = false;
  bool self_rows_ = false;
  std::vector<std::pair<int, int>> self_geometries_;  // pairs of geometries of non-neighbouring bodies
  std::vector<double> greatest_radius_;               // of each geometry over the box of parameters
  std::vector<TaskRow> task_rows_;
  Eigen::Index first_clearance_row_ = 0;
  Eigen::Index clearance_rows_per_goal_ = 0;
  std::vector<int> limited_joints_;  // those with a peak torque, where the task limits torques
  Eigen::Index first_torque_row_ = 0;
  std::vector<int> links_;  // knots of trajectories whose successor is the next goal
  Eigen::Index first_link_row_ = 0;
  Eigen::Index first_task_row_ = 0;
};

}  // namespace modsearch
