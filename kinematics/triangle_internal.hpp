#pragma once

#include <array>
#include <modsearch/kinematics/separation.hpp>
#include <modsearch/kinematics/shape.hpp>

namespace modsearch::detail {

/// Corners of a triangle in the world [m].
using Triangle = std::array<Eigen::Vector3d, 3>;

/// Separation of a shape that is no mesh and a triangle `b`: the least signed distance from the shape of any point of
/// the triangle, which is the gap if they are apart and minus the depth of the deepest point if they overlap.
/// Continuous. Accurate to about 1e-9 of the size.
[[nodiscard]] Separation triangle_separation(const Shape& a, const Eigen::Isometry3d& X_WA, const Triangle& b);

/// Separation of two triangles: the gap, or minus the least translation that parts them.
[[nodiscard]] Separation triangle_separation(const Triangle& a, const Triangle& b);

}  // namespace modsearch::detail
