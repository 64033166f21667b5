#pragma once

#include <modsearch/kinematics/shape.hpp>

namespace modsearch {

/// How far two placed shapes are apart and where they come closest.
struct Separation {
  /// Signed distance [m]: > 0 the gap, 0 touching, < 0 minus the depth of penetration, the least translation that parts
  /// the two. A mesh is a surface: its depth in another shape is that of its deepest point.
  double distance = 0.0;
  Eigen::Vector3d p_WA = Eigen::Vector3d::Zero();       ///< witness point on A, world frame [m]
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();       ///< witness point on B: p_WA - p_WB = distance * normal_W [m]
  Eigen::Vector3d normal_W = Eigen::Vector3d::UnitZ();  ///< unit vector from B to A: d(distance)/d(translation of A)
};

/// Signed distance with witness points of `a` posed at `X_WA` and `b` posed at `X_WB`. Sizes and poses are taken for
/// granted (`check`). A function of its arguments alone: equal inputs give equal bits, from any thread.
///
/// The distance is continuous in the poses. Where the nearest points are not unique (parallel faces, concentric shapes)
/// one of them is chosen by fixed rules. Methods, accuracy and the comparison with FCL: docs/clearance.md.
/// Throws std::runtime_error("collision unknown: ...") if FCL, which answers for meshes, fails.
[[nodiscard]] Separation separation(const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b,
                                    const Eigen::Isometry3d& X_WB);

/// The distance of `separation` alone; cheaper where a closed form exists.
[[nodiscard]] double signed_distance(const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b,
                                     const Eigen::Isometry3d& X_WB);

/// Whether the two overlap (signed_distance < 0, up to 1e-9 m; 1e-6 m against meshes); cheaper than the distance.
[[nodiscard]] bool overlaps(const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b,
                            const Eigen::Isometry3d& X_WB);

}  // namespace modsearch
