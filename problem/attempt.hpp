#pragma once

#include <Eigen/Core>
#include <limits>
#include <modsearch/kinematics/path_planning.hpp>
#include <optional>
#include <string_view>

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
  kIncomplete,       ///< the library has end effectors and the design ends without one
  kUnreachable,      ///< no posture brings the tip into a goal's region
  kObstacle,         ///< a body overlaps an obstacle at a goal
  kSelfCollision,    ///< two bodies overlap at a goal
  kHomeInCollision,  ///< the motion cannot start
  kNoPath,           ///< no path was found within the planner's budget
  kNotANumber,       ///< a user's problem gave NaN
  kThrew,            ///< a user's problem threw an exception
};
/// "none", "incomplete", "unreachable", "obstacle", ...
[[nodiscard]] std::string_view name(Failure failure);

/// What came of trying to fulfil a task with an arm.
struct Attempt {
  bool reached = false;   ///< all goals' poses, whatever collides
  bool achieved = false;  ///< and the collision level is met too
  bool collides = false;  ///< the level is violated: an overlap, or no path
  Failure why = Failure::kUnreachable;  ///< first reason for not being achieved
  double goal_error = 0.0;  ///< largest distance of the tip from a goal's nominal position [m]
  /// Mean over the goals of |t - p| / |t - b| where not reached, 0 where reached; |t - b| at least 1e-9 m.
  double relative_error = 0.0;
  double clearance = std::numeric_limits<double>::infinity();  ///< least over the goals' postures [m]; < 0: overlap
  Eigen::MatrixXd postures;                                    ///< [n_goals x n_joints]
  std::optional<Path> path;                                    ///< home through all goals; only at level path
  std::vector<int> goal_waypoints;  ///< row of `path` at which each goal is passed [n_goals]
  Work work;
};

}  // namespace modsearch
