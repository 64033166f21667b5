#pragma once

#include <cmath>
#include <modsearch/problem/task.hpp>
#include <numbers>

namespace modsearch::testing {

inline Eigen::Isometry3d at(double x, double y, double z) { return Eigen::Isometry3d{Eigen::Translation3d{x, y, z}}; }

/// Two links of 1 m in the plane z = 0 whose joints turn about z: capsules of radius 0.05 that end 0.1 m short of the
/// joints and may touch one another. `elbow`, `shoulder`: how far the joints turn either way.
inline Chain planar_arm(double elbow = 2.6, double shoulder = std::numbers::pi) {
  ChainBuilder builder{0};
  Eigen::Isometry3d along_x = at(0.5, 0, 0);
  along_x.linear() = Eigen::AngleAxisd{std::numbers::pi / 2, Eigen::Vector3d::UnitY()}.toRotationMatrix();
  const AffineShape capsule{AffineShape::Kind::kCapsule, {0.05, 0.8}, nullptr};
  const double limits[] = {shoulder, elbow};
  for (int i = 0; i < 2; ++i) {
    builder.joint({.name = "turn", .lower = -limits[i], .upper = limits[i]}, i - 1, i);
    builder.body("link", i, 1.0, {{capsule, along_x}}, {.X_FB = at(0.5, 0, 0), .r_com = {}});
    builder.move(at(1, 0, 0));
  }
  return builder.build();
}

inline Arm arm_of(const Chain& chain) { return chain.at(Eigen::VectorXd{0}); }

/// The point at this distance from the base in this direction [rad], within a millimetre.
inline Goal point(const std::string& id, double radius, double angle) {
  return {id, GoalType::kReach, PoseRegion::ball({radius * std::cos(angle), radius * std::sin(angle), 0.0}, 1e-3)};
}

/// The posture of `planar_arm` with its tip there; `side`: sign of the second joint. The triangle of base, elbow and
/// tip has the sides 1, 1 and `radius`.
inline Eigen::RowVector2d reaching(double radius, double angle, double side) {
  const double half = std::acos(0.5 * radius);
  return {angle - side * half, side * 2.0 * half};
}

inline Obstacle ball(const std::string& name, double x, double y, double radius) {
  return {name, {{Sphere{radius}, at(x, y, 0.0)}}};
}

}  // namespace modsearch::testing
