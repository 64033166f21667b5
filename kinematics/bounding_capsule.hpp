#pragma once

#include <modsearch/kinematics/shape.hpp>

namespace modsearch {

/// A capsule in the world that holds a whole shape: cheap to compare, and tight for the long thin bodies of an arm.
struct BoundingCapsule {
  Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();     ///< middle of the segment [m]
  Eigen::Vector3d half_axis_W = Eigen::Vector3d::Zero();  ///< from the middle to one end of the segment [m]; 0: a ball
  double half_length = 0.0;                               ///< |half_axis_W| [m]
  double radius = 0.0;                                    ///< about the segment [m]
};

/// The capsule about `shape` posed at `X_WG`. Sphere and capsule: themselves; cylinder: the segment of its axis; box: a
/// segment along its longest edge; mesh: the ball about its origin with `bounding_radius`, which is computed once by
/// whoever keeps the shape because it visits every vertex.
[[nodiscard]] BoundingCapsule bounding_capsule(const Shape& shape, double bounding_radius,
                                               const Eigen::Isometry3d& X_WG);

/// Signed distance between two capsules [m], which bounds that of the shapes inside from below: parting the capsules
/// parts the shapes. 1e-9 m are taken off, so that rounding never makes it an unsound bound.
[[nodiscard]] double gap(const BoundingCapsule& a, const BoundingCapsule& b);

/// Whether gap(a, b) > `distance` [m]. Cheaper: most pairs of a scene are told apart by the balls about the capsules.
[[nodiscard]] bool apart(const BoundingCapsule& a, const BoundingCapsule& b, double distance);

/// Whether the balls about two capsules alone prove that gap(a, b) > `distance` [m].
[[nodiscard]] inline bool balls_apart(const BoundingCapsule& a, const BoundingCapsule& b, double distance) {
  constexpr double kRounding = 2e-9;
  const double reach = a.half_length + a.radius + b.half_length + b.radius + distance + kRounding;
  return reach < 0.0 || (a.centre_W - b.centre_W).squaredNorm() > reach * reach;
}

}  // namespace modsearch
