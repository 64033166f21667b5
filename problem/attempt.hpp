#pragma once

#include <Eigen/Core>
#include <limits>
#include <modsearch/kinematics/path_planning.hpp>
#include <optional>
#include <string_view>
#include <utility>

namespace modsearch {

/// What counts as a collision (PROBLEM 3).
enum class Level {
  kNone,         ///< nothing
  kPosture,      ///< a body and an obstacle overlap at the posture of a goal
  kPostureSelf,  ///< that, or two bodies that are not neighbours overlap
  kPath,         ///< that, or no collision-free path from home through all goals was found
};
/// "none", "posture", "posture+self", "path".
[[nodiscard]] std::string_view name(Level level);
[[nodiscard]] std::optional<Level> level_from_name(std::string_view name);

/// Why a design does not do what the task asks. Data, not an error.
enum class Failure {
  kNone,
  kIncomplete,        ///< the library has end effectors and the design ends without one
  kProvedInfeasible,  ///< proved: the arm is too short for a goal, whatever its joints do
  kUnreachable,       ///< no posture brings the tip into a goal's region
  kLimit,          ///< a limit keeps the arm from it: the closest posture has a joint at its end, or a joint would have
                   ///< to be faster along a timed trajectory than it may
  kJump,           ///< a trajectory can only be followed by jumping to another branch of postures
  kTorque,         ///< a joint cannot hold the arm at a goal
  kObstacle,       ///< a body overlaps an obstacle at a goal
  kSelfCollision,  ///< two bodies overlap at a goal
  kHomeInCollision,  ///< the motion cannot start
  kNoPath,           ///< no path was found within the planner's budget
  kNotANumber,       ///< a user's problem gave NaN
  kThrew,            ///< a user's problem threw an exception
};
/// "none", "incomplete", "unreachable", "obstacle", ...
[[nodiscard]] std::string_view name(Failure failure);
inline constexpr std::size_t kFailures = static_cast<std::size_t>(Failure::kThrew) + 1;  ///< how many there are

/// Postures that somebody found for the goals of a task. An evaluation tries them before any of its own: they are
/// checked like those, can turn a miss into a reach and never the other way round, and become the attempt's `postures`
/// where the design is achieved with them (PROBLEM 3).
struct Witness {
  Eigen::MatrixXd postures;  ///< [n_goals x n_joints], rad or m; empty: none. Of another size: not looked at
  /// For searches: no others are looked for, and a motion has to be free at states as dense as `verify` takes.
  bool only = false;
  /// Share of the planner's iterations that a motion between them may take, in (0, 1]. A motion that is found within
  /// them is the one that all of them find; the few that take more are many times as dear as the others.
  double patience = 1.0;

  [[nodiscard]] bool empty() const { return postures.size() == 0; }
};

/// What came of trying to fulfil a task with an arm.
struct Attempt {
  bool reached = false;                 ///< all goals' poses, whatever collides
  bool achieved = false;                ///< and the collision level is met too
  bool collides = false;                ///< the level is violated: an overlap, or no path
  Failure why = Failure::kUnreachable;  ///< first reason for not being achieved
  /// Where not achieved: that is how a search for postures or motions ended and no proof. Another attempt, with other
  /// starts or more patience, might succeed.
  bool inconclusive = false;
  double goal_error = 0.0;              ///< largest distance of the tip from a goal's nominal position [m]
  /// Mean over the goals of |t - p| / |t - b| where not reached, 0 where reached; |t - b| at least 1e-9 m.
  double relative_error = 0.0;
  /// Least over the goals' postures where all are reached [m]; < 0: overlap. Where one is missed bodies are asked
  /// whether they overlap, and no more.
  double clearance = std::numeric_limits<double>::infinity();
  /// Likewise the largest share of a joint's peak torque at any posture; 0 where these are not limited.
  double torque_share = 0.0;
  Eigen::MatrixXd postures;  ///< [n_goals x n_joints]
  /// Postures at all poses of each trajectory, in the order of the steps that follow one [n_poses x n_joints].
  std::vector<Eigen::MatrixXd> trajectories{};
  std::optional<Path> path;           ///< home through all goals; only at level path, with times where the task has any
  std::vector<int> goal_waypoints;    ///< row of `path` at which each goal is passed [n_goals]
  std::vector<int> step_waypoints{};  ///< row of `path` at which each step is done [n_steps]; no steps: the goals
  /// Where no path was found: the goals between whose postures the first motion is missing, (from, to); -1: home, or
  /// a pose that is no goal of its own.
  std::optional<std::pair<int, int>> missing_motion{};
  Work work;
};

}  // namespace modsearch
