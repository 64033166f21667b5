#pragma once

#include <modsearch/kinematics/shape.hpp>

namespace modsearch {

/// How far two placed shapes are apart and where they come closest.
struct Separation {
  /// Signed distance [m]: > 0 the gap, 0 touching, < 0 minus the depth of penetration (the least translation that parts
  /// the two). Against a mesh, which is a surface, an overlap counts as -0 depth: see `signed_distance`.
  double distance = 0.0;
  Eigen::Vector3d p_WA = Eigen::Vector3d::Zero();       ///< witness point on A, world frame [m]
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();       ///< witness point on B, world frame [m]
  Eigen::Vector3d normal_W = Eigen::Vector3d::UnitZ();  ///< unit vector from B to A: d(distance)/d(translation of A)
};

/// Signed distance with witness points of `a` posed at `X_WA` and `b` posed at `X_WB`.
[[nodiscard]] Separation separation(const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b,
                                    const Eigen::Isometry3d& X_WB);

/// The distance of `separation` alone; cheaper where a closed form exists.
[[nodiscard]] double signed_distance(const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b,
                                     const Eigen::Isometry3d& X_WB);

/// Whether the two overlap (signed_distance < 0); cheaper than the distance.
[[nodiscard]] bool overlaps(const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b,
                            const Eigen::Isometry3d& X_WB);

}  // namespace modsearch
