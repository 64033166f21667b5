#pragma once

#include <modsearch/problem/task.hpp>

namespace modsearch::detail {

/// Extends `attempt`, which has a posture for every goal and for every pose of every trajectory, by a motion from home
/// through all steps of `task`: in their order or, where that is free, in the one whose motions take least time. The
/// path has times if the task asks for any (a pause, a timed trajectory) or an obstacle moves.
/// Says what is wrong if there is none.
[[nodiscard]] Failure plan_motion(const Task& task, const Arm& arm, const Scene& scene, const AttemptOptions& options,
                                  Attempt& attempt);

}  // namespace modsearch::detail
