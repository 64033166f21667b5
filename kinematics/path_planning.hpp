#pragma once

#include <cstdint>
#include <modsearch/kinematics/scene.hpp>
#include <string_view>

namespace modsearch {

/// A motion through joint space: straight lines between consecutive rows.
struct Path {
  Eigen::MatrixXd waypoints;  ///< [n_waypoints x n_joints], rad and m; empty: no path
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
  double resolution = 0.01;  ///< no body point moves farther between two checked states of an edge [m]
  bool self_collision = true;  ///< non-neighbouring bodies must not overlap either
  int shortcut_attempts = 50;  ///< of the simplification
  std::uint64_t stream = 0;    ///< which fixed sample sequence; equal inputs give equal paths
};

struct Plan {
  PlanStatus status = PlanStatus::kNotFound;
  Path path;                     ///< empty unless kExact
  std::int64_t iterations = 0;   ///< of the planner
  Work work;
};

/// A collision-free motion from `q_start` to `q_goal` [n_joints] for `arm` among the obstacles of `scene`: the straight
/// line where it is free, else RRT-Connect (Kuffner and LaValle 2000) of OMPL, then simplification. Equal inputs give
/// equal paths, in any order of calls and from any thread.
/// Throws std::invalid_argument if a size does not match or a number is not finite.
[[nodiscard]] Plan plan_path(const Arm& arm, const Scene& scene, const Eigen::VectorXd& q_start,
                             const Eigen::VectorXd& q_goal, const PlanOptions& options = {});

/// What an independent look at a path found.
struct PathCheck {
  bool free = false;         ///< within limits and collision-free at every checked state
  bool within_limits = false;
  double clearance = 0.0;    ///< least clearance to obstacles over the checked states [m]; +inf without obstacles
  double self_clearance = 0.0;  ///< likewise between non-neighbouring bodies
  std::int64_t states = 0;
  Work work;
};

/// Walks along `path` so that no body point moves farther than `resolution` [m] between checked states.
[[nodiscard]] PathCheck check_path(const Arm& arm, const Scene& scene, const Path& path, double resolution,
                                   bool self_collision);

}  // namespace modsearch
