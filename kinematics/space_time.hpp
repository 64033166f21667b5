#pragma once

#include <modsearch/kinematics/path_planning.hpp>

namespace modsearch {

/// Least signed distance between any body of the arm at `posture` and any obstacle that moves, where it is at time `t`
/// [s] [m]; never more than `ceiling`.
[[nodiscard]] double clearance_at(const Arm& arm, const Posture& posture, const Scene& scene, double t, Work& work,
                                  double ceiling = std::numeric_limits<double>::infinity());

/// What an independent look at a timed path among moving obstacles found.
struct SpaceTimeCheck {
  bool free = false;       ///< no overlap with a moving obstacle at any checked state
  double clearance = 0.0;  ///< least, over the checked states [m]
  std::int64_t states = 0;
  Work work;
};

/// Walks along `path`, which has times, so that no point of the arm moves farther against any obstacle than
/// `resolution` [m] between checked states; the obstacles that do not move are left to `check_path`. Throws
/// std::invalid_argument for a path without as many times as waypoints, or times that fall.
[[nodiscard]] SpaceTimeCheck check_in_time(const Arm& arm, const Scene& scene, const Path& path, double resolution);

struct TimedPlanOptions {
  PlanOptions plan{};
  double horizon = 60.0;  ///< no plan takes longer than this [s] (arbitrary, ample)
};

/// A motion from `q_start` at time `t_start` to `q_goal` among obstacles that move, at the times when they are where
/// they are. Time is one more dimension, in which a tree only grows forwards (Sintov and Shapiro 2014, Time-based RRT
/// for dynamic environments, doi:10.1109/ICRA.2014.6907855): an edge is a straight line in joints and time that no
/// joint's velocity limit forbids, or a wait. First the straight line at full speed, then the same after waiting, then
/// the tree. The path has times; its end is free of collision for at least `hold` seconds more. Equal inputs, equal
/// paths.
[[nodiscard]] Plan plan_in_time(const Arm& arm, const Scene& scene, const Eigen::VectorXd& q_start, double t_start,
                                const Eigen::VectorXd& q_goal, double hold, const TimedPlanOptions& options = {});

}  // namespace modsearch
