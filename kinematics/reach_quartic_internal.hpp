#pragma once

// Internal: postures of a three-joint arm that bring the tip exactly to the target, by an equation of fourth degree.

#include <modsearch/kinematics/exact_reach_internal.hpp>

namespace modsearch::internal {

/// At most four postures, one for each root of Pieper's quartic, joint limits not looked at (Pieper, The Kinematics of
/// Manipulators under Computer Control, 1968, chapter 4; here in trigonometric form). Where the target is just out of
/// reach a pair of roots is complex; the posture of its argument is close to the nearest one. `distance` is not filled
/// in. Empty unless joints 1 and 2 are revolute. Accurate to the square root of rounding near double roots.
[[nodiscard]] NearestList reaching_postures(const ReachProblem& problem);

}  // namespace modsearch::internal
