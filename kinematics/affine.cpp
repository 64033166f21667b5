#include <modsearch/kinematics/affine.hpp>

#include <algorithm>

namespace modsearch {

AffineScalar AffineScalar::of_parameter(int parameter, double scale, double offset) {
  AffineScalar result{offset};
  result.terms.push_back({parameter, scale});
  return result;
}

double AffineScalar::at(const Eigen::VectorXd& x) const {
  double value = offset;
  for (const Term& term : terms) value += term.scale * x[term.parameter];
  return value;
}

Eigen::VectorXd AffineScalar::gradient(int n_parameters) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(n_parameters);
  for (const Term& term : terms) result[term.parameter] += term.scale;
  return result;
}

double AffineScalar::least(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) const {
  double value = offset;
  for (const Term& term : terms) value += term.scale * (term.scale > 0.0 ? lower : upper)[term.parameter];
  return value;
}

double AffineScalar::greatest(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) const {
  return least(upper, lower);
}

AffineScalar AffineScalar::shifted(int shift) const {
  AffineScalar result = *this;
  for (Term& term : result.terms) term.parameter += shift;
  return result;
}

AffineScalar operator+(AffineScalar a, const AffineScalar& b) {
  a.offset += b.offset;
  for (const AffineScalar::Term& term : b.terms) {
    const auto same = std::find_if(a.terms.begin(), a.terms.end(),
                                   [&](const AffineScalar::Term& other) { return other.parameter == term.parameter; });
    if (same == a.terms.end()) {
      a.terms.push_back(term);
    } else {
      same->scale += term.scale;
    }
  }
  return a;
}

AffineVector::AffineVector(const AffineScalar& x, const AffineScalar& y, const AffineScalar& z) {
  const AffineScalar* const entries[] = {&x, &y, &z};
  for (int axis = 0; axis < 3; ++axis) {
    AffineVector part{Eigen::Vector3d{entries[axis]->offset * Eigen::Vector3d::Unit(axis)}};
    for (const AffineScalar::Term& term : entries[axis]->terms) {
      part.terms.push_back({term.parameter, term.scale * Eigen::Vector3d::Unit(axis)});
    }
    *this = *this + part;
  }
}

Eigen::Vector3d AffineVector::at(const Eigen::VectorXd& x) const {
  Eigen::Vector3d value = offset;
  for (const Term& term : terms) value += x[term.parameter] * term.direction;
  return value;
}

AffineVector AffineVector::rotated(const Eigen::Matrix3d& rotation) const {
  AffineVector result{Eigen::Vector3d{rotation * offset}};
  for (const Term& term : terms) result.terms.push_back({term.parameter, rotation * term.direction});
  return result;
}

AffineVector AffineVector::shifted(int shift) const {
  AffineVector result = *this;
  for (Term& term : result.terms) term.parameter += shift;
  return result;
}

AffineVector operator+(AffineVector a, const AffineVector& b) {
  a.offset += b.offset;
  for (const AffineVector::Term& term : b.terms) {
    const auto same = std::find_if(a.terms.begin(), a.terms.end(),
                                   [&](const AffineVector::Term& other) { return other.parameter == term.parameter; });
    if (same == a.terms.end()) {
      a.terms.push_back(term);
    } else {
      same->direction += term.direction;
    }
  }
  return a;
}

Eigen::Isometry3d AffinePose::at(const Eigen::VectorXd& x) const {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = rotation;
  X.translation() = translation.at(x);
  return X;
}

AffinePose AffinePose::inverse() const {
  const Eigen::Matrix3d transposed = rotation.transpose();
  return {transposed, translation.rotated(-transposed)};
}

AffinePose AffinePose::shifted(int shift) const { return {rotation, translation.shifted(shift)}; }

AffinePose operator*(const AffinePose& X_AB, const AffinePose& X_BC) {
  return {X_AB.rotation * X_BC.rotation, X_AB.translation + X_BC.translation.rotated(X_AB.rotation)};
}

Shape AffineShape::at(const Eigen::VectorXd& x) const {
  switch (kind) {
    case Kind::kSphere:
      return Sphere{size[0].at(x)};
    case Kind::kBox:
      return Box{{size[0].at(x), size[1].at(x), size[2].at(x)}};
    case Kind::kCylinder:
      return Cylinder{size[0].at(x), size[1].at(x)};
    case Kind::kCapsule:
      return Capsule{size[0].at(x), size[1].at(x)};
    case Kind::kMesh:
      return Mesh{mesh};
  }
  return {};
}

AffineShape AffineShape::shifted(int shift) const {
  AffineShape result = *this;
  for (AffineScalar& length : result.size) length = length.shifted(shift);
  return result;
}

}  // namespace modsearch
