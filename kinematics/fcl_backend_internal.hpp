#pragma once

#include <modsearch/kinematics/separation.hpp>
#include <modsearch/kinematics/shape.hpp>

namespace modsearch::detail {

/// Whether `a` touches a triangle of the mesh `b`, by FCL. Throws std::runtime_error("collision unknown: ...") if FCL
/// fails.
[[nodiscard]] bool mesh_overlaps(const Shape& a, const Eigen::Isometry3d& X_WA, const Mesh& b,
                                 const Eigen::Isometry3d& X_WB);

/// Separation of `a` and the mesh `b`: the least over their triangles. Apart, the distance; overlapping, minus the
/// depth of the deepest triangle, which frees that triangle but not always the others. Throws
/// std::runtime_error("collision unknown: ...") if FCL, which searches pairs of meshes, fails.
[[nodiscard]] Separation mesh_separation(const Shape& a, const Eigen::Isometry3d& X_WA, const Mesh& b,
                                         const Eigen::Isometry3d& X_WB);

}  // namespace modsearch::detail
