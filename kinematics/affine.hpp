#pragma once

#include <Eigen/Geometry>
#include <modsearch/kinematics/shape.hpp>
#include <vector>

namespace modsearch {

/// A number affine in the parameters x of a design: offset + sum_i scale_i * x[parameter_i].
///
/// Lengths, masses and radii of a module library are of this form (and nothing else is), which makes the tip position
/// affine in all lengths for fixed joint angles: exact derivatives, and linear programs as bounds.
struct AffineScalar {
  struct Term {
    int parameter = 0;
    double scale = 0.0;
  };
  double offset = 0.0;
  std::vector<Term> terms;

  AffineScalar() = default;
  AffineScalar(double constant) : offset{constant} {}  // NOLINT: a constant is an affine number
  [[nodiscard]] static AffineScalar of_parameter(int parameter, double scale = 1.0, double offset = 0.0);

  /// Value at `x` [n_parameters].
  [[nodiscard]] double at(const Eigen::VectorXd& x) const;
  /// d value / d x, dense [n_parameters].
  [[nodiscard]] Eigen::VectorXd gradient(int n_parameters) const;
  /// Least and greatest value over the box lower <= x <= upper.
  [[nodiscard]] double least(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) const;
  [[nodiscard]] double greatest(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) const;
  /// The same number with every parameter index raised by `shift` (from a module's own x to the design's x).
  [[nodiscard]] AffineScalar shifted(int shift) const;
};
[[nodiscard]] AffineScalar operator+(AffineScalar a, const AffineScalar& b);

/// A vector affine in the parameters: offset + sum_i direction_i * x[parameter_i], in metres.
struct AffineVector {
  struct Term {
    int parameter = 0;
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  };
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  std::vector<Term> terms;  ///< at most one per parameter

  AffineVector() = default;
  AffineVector(const Eigen::Vector3d& constant) : offset{constant} {}  // NOLINT: a constant is an affine vector
  AffineVector(const AffineScalar& x, const AffineScalar& y, const AffineScalar& z);

  [[nodiscard]] Eigen::Vector3d at(const Eigen::VectorXd& x) const;
  [[nodiscard]] AffineVector rotated(const Eigen::Matrix3d& rotation) const;
  [[nodiscard]] AffineVector shifted(int shift) const;
};
[[nodiscard]] AffineVector operator+(AffineVector a, const AffineVector& b);

/// A pose whose rotation is fixed and whose translation is affine in the parameters.
struct AffinePose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  AffineVector translation;

  AffinePose() = default;
  AffinePose(const Eigen::Isometry3d& X) : rotation{X.linear()}, translation{X.translation()} {}  // NOLINT
  AffinePose(const Eigen::Matrix3d& R, AffineVector p) : rotation{R}, translation{std::move(p)} {}

  [[nodiscard]] Eigen::Isometry3d at(const Eigen::VectorXd& x) const;
  [[nodiscard]] AffinePose inverse() const;
  [[nodiscard]] AffinePose shifted(int shift) const;
};
/// X_AC = X_AB * X_BC.
[[nodiscard]] AffinePose operator*(const AffinePose& X_AB, const AffinePose& X_BC);

/// A shape whose sizes are affine in the parameters.
struct AffineShape {
  enum class Kind { kSphere, kBox, kCylinder, kCapsule, kMesh };
  Kind kind = Kind::kSphere;
  /// Sphere: radius. Box: x, y, z. Cylinder and capsule: radius, length. Mesh: none. [m]
  std::vector<AffineScalar> size;
  std::shared_ptr<const TriangleMesh> mesh;

  [[nodiscard]] Shape at(const Eigen::VectorXd& x) const;
  [[nodiscard]] AffineShape shifted(int shift) const;
};

}  // namespace modsearch
