#pragma once

#include <modsearch/kinematics/separation.hpp>
#include <modsearch/kinematics/shape.hpp>

namespace modsearch::detail {

/// Builds what distances to `shape` take beside it, so that no distance has to: seconds for a mesh of a million triangles,
/// nothing for other shapes.
void prepare(const Shape& shape);

/// Whether `a` touches a triangle of the mesh `b`, by FCL. Throws std::runtime_error("collision unknown: ...") if FCL
/// fails.
[[nodiscard]] bool mesh_overlaps(const Shape& a, const Eigen::Isometry3d& X_WA, const Mesh& b,
                                 const Eigen::Isometry3d& X_WB);

/// The same of two shapes of which one or both are meshes, where `least_distance` has been asked in vain.
[[nodiscard]] bool mesh_touches(const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b,
                                const Eigen::Isometry3d& X_WB);

/// Separation of `a` and the mesh `b`: the least over their triangles. Apart, the distance; overlapping, minus the
/// depth of the deepest triangle, which frees that triangle but not always the others. Throws
/// std::runtime_error("collision unknown: ...") if FCL, which searches pairs of meshes, fails.
[[nodiscard]] Separation mesh_separation(const Shape& a, const Eigen::Isometry3d& X_WA, const Mesh& b,
                                         const Eigen::Isometry3d& X_WB);

/// A distance that the two have at least, one of which is a mesh and the other is not; <= 0: not known to be apart.
[[nodiscard]] double least_distance(const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b,
                                    const Eigen::Isometry3d& X_WB);

/// signed_distance, but never more than `ceiling`, and where it is at most `floor` any number between it and `floor`:
/// a mesh is not searched for more than that. Which of the two shapes is a mesh, if any, does not matter.
[[nodiscard]] double distance_within(const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b,
                                     const Eigen::Isometry3d& X_WB, double ceiling, double floor);

}  // namespace modsearch::detail
