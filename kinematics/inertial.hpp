#pragma once

#include <modsearch/kinematics/chain.hpp>
#include <optional>
#include <span>

namespace modsearch {

/// How mass is spread over a rigid body, in some frame F (URDF's `inertial`).
struct Inertial {
  double mass = 0.0;                                  ///< [kg]
  Eigen::Vector3d p_FC = Eigen::Vector3d::Zero();     ///< centre of mass C [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about C, axes of F [kg m^2]
};

/// The two bodies as one, both given in the same frame.
[[nodiscard]] Inertial operator+(const Inertial& a, const Inertial& b);
/// The same body seen from frame A.
[[nodiscard]] Inertial operator*(const Eigen::Isometry3d& X_AF, const Inertial& body);

/// A rigid body can be like that: a positive mass, and positive principal moments none of which exceeds the sum of the
/// two others (the triangle inequality; Traversaro et al. 2016, "Identification of fully physical consistent inertial
/// parameters using optimization on manifolds", doi:10.1109/IROS.2016.7759801). `slack`: relative, for rounding.
[[nodiscard]] bool physical(const Inertial& body, double slack = 1e-9);

/// `mass` [kg] spread evenly over solid `shapes`, overlaps counted twice; a mesh is what its surface encloses, or its
/// bounding box where it encloses nothing. Empty if the shapes have no volume.
[[nodiscard]] std::optional<Inertial> evenly_spread(double mass, std::span<const PlacedShape> shapes);

/// Mass, centre of mass and inertia of `body` at the parameters `x` of its chain, in the frame the body moves with.
[[nodiscard]] Inertial inertial(const Body& body, const Eigen::VectorXd& x);

/// The same, made physical where it is not: a library that gives a mass and no inertia gets that of its shapes, or of a
/// ball of steel where it has none. A body without mass stays without.
[[nodiscard]] Inertial physical_inertial(const Body& body, const Eigen::VectorXd& x);

}  // namespace modsearch
