#pragma once

// Proofs that a module overlaps an obstacle wherever it may stand. Internal to the problem floor.

#include <modsearch/kinematics/scene.hpp>
#include <modsearch/problem/pose_enclosure_internal.hpp>
#include <modsearch/problem/rigid_ends_internal.hpp>
#include <optional>

namespace modsearch::detail {

/// Nothing shallower is claimed [m]: a hundred thousand times what rounding may have added to a sum of some dozens of
/// numbers of at most kFarthest, and what tells whether bodies overlap is exact to a micrometre.
inline constexpr double kLeastDepth = 1e-6;
inline constexpr double kFarthest = 1e3;  // [m]

/// How deep the module is in the obstacle at least, at every pose of the reference frame within `poses` and for all
/// parameters of their box [m]; nothing if that is not proved. Moving obstacles and meshes are left alone.
///
/// What proves it is a point of the module, the same share of its sizes for all parameters, which is inside the
/// obstacle by more than it can be carried: by the tolerance of the position, by that of the rotation, by the
/// parameters. The box of the parameters is cut where one point is not enough for all of it. The search for the point
/// proves nothing and may be as rough as it likes; the point does.
[[nodiscard]] std::optional<double> sure_overlap(const RigidModule& module, const PoseEnclosure& poses,
                                                 const Obstacle& obstacle);

}  // namespace modsearch::detail
