#pragma once

#include <modsearch/problem/leg_planner_internal.hpp>
#include <modsearch/problem/task.hpp>

namespace modsearch::detail {

/// How planning a motion ended.
struct MotionEnd {
  Failure why = Failure::kNone;
  int from = -1;  ///< goal at whose posture the missing part begins; -1: home, or a pose that is no goal of its own
  int to = -1;    ///< goal at whose posture it would have ended
};

/// Extends `attempt`, which has a posture for every goal and for every pose of every trajectory, by a motion from
/// `home` through all steps of `task`: in their order or, where that is free, in the one whose motions take least time.
/// The path has times if the task asks for any (a pause, a timed trajectory) or an obstacle moves.
/// Says what is wrong, and where, if there is none.
[[nodiscard]] MotionEnd plan_motion(const Task& task, const Arm& arm, const Scene& scene, const AttemptOptions& options,
                                    const Eigen::VectorXd& home, LegPlanner& legs, Attempt& attempt);

}  // namespace modsearch::detail
