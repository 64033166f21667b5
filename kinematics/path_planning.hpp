#pragma once

#include <cstdint>
#include <modsearch/kinematics/scene.hpp>
#include <string_view>

namespace modsearch {

/// A motion through joint space: straight lines between consecutive rows.
struct Path {
  Eigen::MatrixXd waypoints;    ///< [n_waypoints x n_joints], rad and m; empty: no path
  std::vector<double> times{};  ///< of the waypoints, not falling [s]; empty: as fast as the joints may
};

enum class PlanStatus {
  kExact,         ///< a path from start to goal that passed the edge check
  kNotFound,      ///< none found within the budget of iterations: says nothing about existence
  kInvalidStart,  ///< the start is in collision or outside the limits
  kInvalidGoal,   ///< the goal is in collision or outside the limits
};
[[nodiscard]] std::string_view name(PlanStatus status);

struct PlanOptions {
  std::int64_t max_iterations = 5000;  ///< of RRT-Connect; the only end but success: no clock (arbitrary, ample)
  /// No body point moves farther between two states of an edge that are known to be free [m]. Half of it is how deep an
  /// obstacle can be missed; a tenth of a link's diameter (arbitrary).
  double resolution = 0.01;
  bool self_collision = true;  ///< non-neighbouring bodies must not overlap either
  int shortcut_attempts = 50;  ///< of the simplification (arbitrary)
  std::uint64_t stream = 0;    ///< which fixed sample sequence; equal inputs give equal paths
};

struct Plan {
  PlanStatus status = PlanStatus::kNotFound;
  Path path;                    ///< empty unless kExact; first row the start, last row the goal, at least two rows
  std::int64_t iterations = 0;  ///< of the planner: samples drawn, 0 where the straight line is free
  Work work;
};

/// A collision-free motion from `q_start` to `q_goal` [n_joints] for `arm` among the obstacles of `scene`: the straight
/// line where it is free, else RRT-Connect (Kuffner and LaValle 2000, doi:10.1109/ROBOT.2000.844730) of OMPL, then
/// simplification. Equal inputs give paths equal to the last bit, in any order of calls and from any thread.
///
/// Guarantee of kExact: along the whole path, every body point is within `resolution` / 2 of where it was at a state
/// without overlap. So nothing ever reaches deeper than that into a body, however thin it is, nor a body deeper than
/// that into anything; and where every such state has a clearance of `resolution` / 2, the path is free everywhere.
///
/// Joint angles are numbers, never wrapped: q and q + 2 pi are two states. The plan stays within the joint limits, and
/// where these are wider, within two turns either side of 0 (or start and goal, if these lie farther out); a joint that
/// slides without limits moves a metre beyond start and goal at most.
///
/// OMPL's messages are switched off, for the whole process.
/// Throws std::invalid_argument if a size does not match or a number is not finite.
[[nodiscard]] Plan plan_path(const Arm& arm, const Scene& scene, const Eigen::VectorXd& q_start,
                             const Eigen::VectorXd& q_goal, const PlanOptions& options = {});

/// What an independent look at a path found.
struct PathCheck {
  bool free = false;  ///< within limits and collision-free at every checked state; false for an empty path
  bool within_limits = false;
  double clearance = 0.0;       ///< least clearance to obstacles over the checked states [m]; +inf without obstacles
  double self_clearance = 0.0;  ///< likewise between non-neighbouring bodies; +inf if these were not asked for
  std::int64_t states = 0;      ///< checked: all of them, nothing is skipped
  Work work;
};

/// Walks along `path` so that no body point moves farther than `resolution` [m] between checked states.
/// Between these every body point is within half of that of where it was at one of them: the clearance holds everywhere
/// but for `resolution` / 2.
/// Throws std::invalid_argument if a size does not match or a number is not finite.
[[nodiscard]] PathCheck check_path(const Arm& arm, const Scene& scene, const Path& path, double resolution,
                                   bool self_collision);

}  // namespace modsearch
