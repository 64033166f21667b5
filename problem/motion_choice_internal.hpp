#pragma once

#include <modsearch/problem/trial_internal.hpp>

namespace modsearch::detail {

/// A motion from home through all steps of `task` for a trial that has reached everything: through the postures that it
/// has, and where no motion is found through others. `trial` then has the postures that the motion passes through.
/// Says what is wrong if there is none.
///
/// The part that is missing leads from one goal to another: the next posture of either is tried, those combinations
/// first that are least far down the goals' lists, those lists sorted by clearance. Every further part gets an eighth
/// of the planner's iterations and at most eight of them fail, so that a design without a path costs twice what one
/// look takes and no more.
[[nodiscard]] Failure plan_motion(const Task& task, const Arm& arm, const Scene& scene, const AttemptOptions& options,
                                  Trial& trial);

}  // namespace modsearch::detail
