#pragma once

#include <memory>
#include <modsearch/kinematics/inverse_kinematics.hpp>
#include <modsearch/kinematics/path_planning.hpp>
#include <modsearch/problem/attempt.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace modsearch {

class RowSink;

enum class GoalType {
  kAt,     ///< pass the pose
  kReach,  ///< be there with zero velocity of the TCP
};
[[nodiscard]] std::string_view name(GoalType type);

/// Where the tip has to be.
struct Goal {
  std::string id;
  GoalType type = GoalType::kReach;
  PoseRegion region;

  [[nodiscard]] Eigen::Vector3d position() const { return region.nominal().translation(); }
};

/// How hard an attempt tries; part of the problem, so that evaluating stays a function of the design.
struct AttemptOptions {
  Level level = Level::kPosture;
  IkOptions ik;
  PlanOptions planner;
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  ///< position of the base, for the relative error
};

/// What the arm has to do. A new kind of task declares its goals, and everything else follows from them: the attempt, the
/// smooth program, an agent's features. It may override any of that.
class Task {
 public:
  virtual ~Task() = default;
  [[nodiscard]] virtual std::string_view name() const = 0;
  /// Goals in the order in which they are visited; at least one.
  [[nodiscard]] virtual std::span<const Goal> goals() const = 0;
  /// Joint configuration the motion starts from, clamped into the limits; empty: all joints 0.
  [[nodiscard]] virtual Eigen::VectorXd home() const { return {}; }
  /// The task as numbers of fixed length, about in [-1, 1] for an arm of a few metres; by default the goals' positions.
  [[nodiscard]] virtual Eigen::VectorXd features() const;
  /// Tries to fulfil the goals with `arm` among `scene`. By default: inverse kinematics goal by goal, the posture with the
  /// largest clearance among equally close ones, the collision level, and at level path a motion from home through all
  /// goals.
  [[nodiscard]] virtual Attempt attempt(const Arm& arm, const Scene& scene, const AttemptOptions& options) const;
  /// Rows of the smooth program that the goals cannot say; nothing by default.
  virtual void add_rows(RowSink& sink, const Chain& chain) const;
};

/// A task of goals that are poses, nothing more: what task files describe.
class GoalTask final : public Task {
 public:
  /// Throws std::invalid_argument without goals.
  GoalTask(std::string name, std::vector<Goal> goals, Eigen::VectorXd home = {});

  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] std::span<const Goal> goals() const override { return goals_; }
  [[nodiscard]] Eigen::VectorXd home() const override { return home_; }

 private:
  std::string name_;
  std::vector<Goal> goals_;
  Eigen::VectorXd home_;
};

/// The joint configuration a motion of `arm` starts from: the task's home filled with zeros and clamped into the limits.
[[nodiscard]] Eigen::VectorXd home_posture(const Task& task, const Chain& chain);

}  // namespace modsearch
