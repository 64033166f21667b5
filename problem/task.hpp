#pragma once

#include <memory>
#include <modsearch/kinematics/inverse_kinematics.hpp>
#include <modsearch/kinematics/path_planning.hpp>
#include <modsearch/kinematics/pose_following.hpp>
#include <modsearch/problem/attempt.hpp>
#include <modsearch/problem/goal.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace modsearch {

class RowSink;

/// How hard an attempt tries; part of the problem, so that evaluating stays a function of the design.
struct AttemptOptions {
  Level level = Level::kPosture;
  IkOptions ik;
  PlanOptions planner;
  FollowOptions follow{};
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  ///< position of the base, for the relative error
  double time_step = 0.01;                         ///< motions take whole steps, where a task has times [s]
  /// The postures to look at, in place of inverse kinematics; empty, of another size or not finite: none. One outside
  /// the joint limits counts as the nearest within them, a trajectory begins at that of its first knot.
  Witness witness{};
};

/// What the arm bears while it stands still, and whether its joints have to be strong enough for it.
struct Statics {
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  ///< [m/s^2]
  double payload = 0.0;                      ///< point mass at the tip [kg]
  bool limited = false;                      ///< no joint may need more than its peak torque
};

/// What the arm has to do. A new kind of task declares its goals, and everything else follows from them: the attempt,
/// the smooth program, the bounds, an agent's features. It may override any of that.
///
/// Goals are poses, each with a posture of its own. Steps say what is done with them: visit, follow, pause, return.
class Task {
 public:
  virtual ~Task() = default;
  [[nodiscard]] virtual std::string_view name() const = 0;
  /// At least one.
  [[nodiscard]] virtual std::span<const Goal> goals() const = 0;
  /// What is done, in order. Empty (the default): every goal is visited.
  [[nodiscard]] virtual std::span<const TaskStep> steps() const { return {}; }
  /// The order of the steps is free: whichever makes the joints travel least. A pause and a return stay behind the step
  /// before them.
  [[nodiscard]] virtual bool any_order() const { return false; }
  [[nodiscard]] virtual Statics statics() const { return {}; }
  /// Joint configuration the motion starts from, clamped into the limits; empty: none is asked for (home_posture).
  [[nodiscard]] virtual Eigen::VectorXd home() const { return {}; }
  /// The task as numbers of fixed length, about in [-1, 1] for an arm of a few metres; by default the goals' positions.
  [[nodiscard]] virtual Eigen::VectorXd features() const;
  /// Tries to fulfil the goals with `arm` among `scene`. By default: inverse kinematics goal by goal, the posture with
  /// the largest clearance among equally close ones that the joints can hold, trajectories pose by pose from there, the
  /// collision level, and at level path a motion from home through all steps: where none is found, through other
  /// postures that are free (docs/tasks.md).
  [[nodiscard]] virtual Attempt attempt(const Arm& arm, const Scene& scene, const AttemptOptions& options) const;
  /// Rows of the smooth program that the goals cannot say; nothing by default.
  virtual void add_rows(RowSink& sink, const Chain& chain) const;
};

/// Everything a GoalTask is made of.
struct GoalTaskSpec {
  std::string name;
  std::vector<Goal> goals{};
  Eigen::VectorXd home{};
  std::vector<TaskStep> steps{};  ///< empty: every goal is visited, in order
  bool any_order = false;
  Statics statics{};
};

/// A task of goals, nothing more: what task files describe.
class GoalTask final : public Task {
 public:
  /// Throws std::invalid_argument without goals, and for a step that speaks of goals that do not exist, belong to
  /// another step or, where the order is given, come later.
  explicit GoalTask(GoalTaskSpec spec);
  GoalTask(std::string name, std::vector<Goal> goals, Eigen::VectorXd home = {})
      : GoalTask{GoalTaskSpec{.name = std::move(name), .goals = std::move(goals), .home = std::move(home)}} {}

  [[nodiscard]] const GoalTaskSpec& spec() const { return spec_; }
  [[nodiscard]] std::string_view name() const override { return spec_.name; }
  [[nodiscard]] std::span<const Goal> goals() const override { return spec_.goals; }
  [[nodiscard]] std::span<const TaskStep> steps() const override { return spec_.steps; }
  [[nodiscard]] bool any_order() const override { return spec_.any_order; }
  [[nodiscard]] Statics statics() const override { return spec_.statics; }
  [[nodiscard]] Eigen::VectorXd home() const override { return spec_.home; }

 private:
  GoalTaskSpec spec_;
};

/// The joint configuration a motion of `arm` starts from (PROBLEM 3): the task's home, filled with zeros and clamped
/// into the limits, whatever stands there. A task without one: all joints 0, clamped, where that touches nothing; else
/// the first posture that does of a fixed low-discrepancy set over the limits; else, of 256 all in vain, all joints 0.
[[nodiscard]] Eigen::VectorXd home_posture(const Task& task, const Arm& arm, const Scene& scene);

/// The steps of a task; every goal visited in turn where it declares none.
[[nodiscard]] std::vector<TaskStep> steps_of(const Task& task);
/// Times matter: the task has a pause or a timed trajectory, or an obstacle moves.
[[nodiscard]] bool is_timed(const Task& task, const Scene& scene);
/// What acts on the arm at goal `goal` of `task`.
[[nodiscard]] StaticLoad load_at(const Task& task, int goal);

}  // namespace modsearch
