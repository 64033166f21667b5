#pragma once

// What the tests of separations share. Distances are judged by certificates, not by trust: a supporting plane of each
// shape proves that they are at least d apart, witness points on the shapes prove that they are at most d apart.
// Supports and memberships are written down here again, apart from the library. FCL is the second opinion; where it
// differs, the certificate says who is right.

#include <fcl/fcl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <modsearch/kinematics/separation.hpp>
#include <random>
#include <string>

namespace modsearch::separation_checks {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

inline constexpr double kPi = 3.14159265358979323846;

inline Isometry3d at(double x, double y, double z) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = Vector3d(x, y, z);
  return X;
}

inline Isometry3d turned(const Isometry3d& X, double angle, const Vector3d& axis) {
  return X * AngleAxisd(angle, axis.normalized());
}

// ---- independent geometry ----

/// Largest value of n.p over the points p of the shape, in its frame; `n` a unit vector.
inline double support(const Shape& shape, const Vector3d& n) {
  if (const auto* s = std::get_if<Sphere>(&shape)) return s->radius;
  if (const auto* s = std::get_if<Capsule>(&shape)) return s->radius + 0.5 * s->length * std::abs(n.z());
  if (const auto* s = std::get_if<Cylinder>(&shape)) {
    return s->radius * std::hypot(n.x(), n.y()) + 0.5 * s->length * std::abs(n.z());
  }
  if (const auto* s = std::get_if<Box>(&shape)) return 0.5 * s->size.dot(n.cwiseAbs());
  double largest = -1e300;
  for (const Vector3d& v : std::get<Mesh>(shape).triangles->vertices) largest = std::max(largest, n.dot(v));
  return largest;
}

/// How far the point is outside of the shape, in its frame; 0 or less inside. No mesh.
inline double outside(const Shape& shape, const Vector3d& p) {
  const double rho = std::hypot(p.x(), p.y());
  if (const auto* s = std::get_if<Sphere>(&shape)) return p.norm() - s->radius;
  if (const auto* s = std::get_if<Capsule>(&shape)) {
    return std::hypot(rho, std::max(0.0, std::abs(p.z()) - 0.5 * s->length)) - s->radius;
  }
  if (const auto* s = std::get_if<Cylinder>(&shape)) {
    return std::max(rho - s->radius, std::abs(p.z()) - 0.5 * s->length);
  }
  return (p.cwiseAbs() - 0.5 * std::get<Box>(shape).size).maxCoeff();
}

/// Lower bound of the signed distance: the gap between supporting planes with normal `n`.
inline double plane_gap(const Shape& a, const Isometry3d& X_WA, const Shape& b, const Isometry3d& X_WB,
                        const Vector3d& n) {
  return n.dot(X_WA.translation() - X_WB.translation()) - support(a, -(X_WA.linear().transpose() * n)) -
         support(b, X_WB.linear().transpose() * n);
}

// ---- random shapes ----

enum class Kind { kSphere, kCapsule, kCylinder, kBox };

inline std::string name(Kind kind) {
  switch (kind) {
    case Kind::kSphere:
      return "Sphere";
    case Kind::kCapsule:
      return "Capsule";
    case Kind::kCylinder:
      return "Cylinder";
    case Kind::kBox:
      return "Box";
  }
  return "";
}

class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine_); }

  Vector3d in_cube(double half) { return {uniform(-half, half), uniform(-half, half), uniform(-half, half)}; }

  Vector3d direction() {
    std::normal_distribution<double> normal;
    const Vector3d v(normal(engine_), normal(engine_), normal(engine_));
    return v.normalized();
  }

  Isometry3d pose(double half) {
    Isometry3d X = Isometry3d::Identity();
    X.translation() = in_cube(half);
    return turned(X, uniform(0, kPi), direction());
  }

  /// Axes along the world's, positions on a grid of 0.1 m: faces, edges and axes coincide all the time.
  Isometry3d aligned_pose(double half) {
    Isometry3d X = Isometry3d::Identity();
    for (int i = 0; i < 3; ++i) X.translation()[i] = 0.1 * std::round(10.0 * uniform(-half, half));
    const std::array<Vector3d, 3> axes{Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
    X.linear().col(0) = axes[static_cast<std::size_t>(below(3))] * (below(2) == 0 ? 1.0 : -1.0);
    do {
      X.linear().col(1) = axes[static_cast<std::size_t>(below(3))];
    } while (X.linear().col(1).dot(X.linear().col(0)) != 0.0);
    X.linear().col(2) = X.linear().col(0).cross(X.linear().col(1));
    return X;
  }

  Shape shape(Kind kind) {
    switch (kind) {
      case Kind::kSphere:
        return Sphere{uniform(0.02, 0.4)};
      case Kind::kCapsule:
        return Capsule{uniform(0.02, 0.3), uniform(0.0, 1.0)};
      case Kind::kCylinder:
        return Cylinder{uniform(0.02, 0.3), uniform(0.02, 1.0)};
      case Kind::kBox:
        return Box{Vector3d(uniform(0.02, 0.8), uniform(0.02, 0.8), uniform(0.02, 0.8))};
    }
    return Sphere{};
  }

  Shape round_shape(Kind kind) {
    const auto step = [&] { return 0.1 * (1 + below(4)); };
    switch (kind) {
      case Kind::kSphere:
        return Sphere{step()};
      case Kind::kCapsule:
        return Capsule{step(), 2.0 * step()};
      case Kind::kCylinder:
        return Cylinder{step(), 2.0 * step()};
      case Kind::kBox:
        return Box{Vector3d(2.0 * step(), 2.0 * step(), 2.0 * step())};
    }
    return Sphere{};
  }

 private:
  std::mt19937 engine_;
};

// ---- FCL, the second opinion ----

inline std::shared_ptr<fcl::CollisionGeometryd> fcl_geometry(const Shape& shape) {
  if (const auto* s = std::get_if<Sphere>(&shape)) return std::make_shared<fcl::Sphered>(s->radius);
  if (const auto* s = std::get_if<Capsule>(&shape)) return std::make_shared<fcl::Capsuled>(s->radius, s->length);
  if (const auto* s = std::get_if<Cylinder>(&shape)) return std::make_shared<fcl::Cylinderd>(s->radius, s->length);
  if (const auto* s = std::get_if<Box>(&shape)) return std::make_shared<fcl::Boxd>(s->size);
  const TriangleMesh& mesh = *std::get<Mesh>(shape).triangles;
  auto tree = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
  tree->beginModel();
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const auto corner = [&](int k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    tree->addTriangle(corner(0), corner(1), corner(2));
  }
  tree->endModel();
  return tree;
}

inline bool fcl_overlaps(const Shape& a, const Isometry3d& X_WA, const Shape& b, const Isometry3d& X_WB) {
  fcl::CollisionRequestd request;
  request.gjk_solver_type = fcl::GST_INDEP;
  fcl::CollisionResultd result;
  return fcl::collide(fcl_geometry(a).get(), X_WA, fcl_geometry(b).get(), X_WB, request, result) > 0;
}

inline double fcl_distance(const Shape& a, const Isometry3d& X_WA, const Shape& b, const Isometry3d& X_WB) {
  fcl::DistanceRequestd request;
  request.gjk_solver_type = fcl::GST_INDEP;
  fcl::DistanceResultd result;
  fcl::distance(fcl_geometry(a).get(), X_WA, fcl_geometry(b).get(), X_WB, request, result);
  return result.min_distance;
}

// ---- pairs ----

struct Pair {
  Shape a;
  Isometry3d X_WA;
  Shape b;
  Isometry3d X_WB;
};

inline Separation separation(const Pair& p) { return modsearch::separation(p.a, p.X_WA, p.b, p.X_WB); }
inline double signed_distance(const Pair& p) { return modsearch::signed_distance(p.a, p.X_WA, p.b, p.X_WB); }
inline bool overlaps(const Pair& p) { return modsearch::overlaps(p.a, p.X_WA, p.b, p.X_WB); }

/// The answer is proven to within `tolerance` [m]: supporting planes from below, witness points from above. Inside,
/// where no point can prove a depth, that moving A by the depth along the normal parts the two, and that the witnesses
/// lie on the shapes, as far apart as the depth, to within `inside_tolerance` [m].
inline void expect_certified(const Pair& pair, const Separation& s, double tolerance, double inside_tolerance) {
  EXPECT_NEAR(s.normal_W.norm(), 1.0, 1e-12);
  EXPECT_NEAR(plane_gap(pair.a, pair.X_WA, pair.b, pair.X_WB, s.normal_W), s.distance, tolerance);
  if (s.distance < 0.0) tolerance = inside_tolerance;
  EXPECT_LE(outside(pair.a, pair.X_WA.inverse() * s.p_WA), tolerance);
  EXPECT_LE(outside(pair.b, pair.X_WB.inverse() * s.p_WB), tolerance);
  if (s.distance > 0.0) {
    EXPECT_NEAR((s.p_WA - s.p_WB).norm(), s.distance, tolerance);
  } else {
    EXPECT_NEAR((s.p_WA - s.p_WB).dot(s.normal_W), s.distance, tolerance);
  }
}

inline void expect_certified(const Pair& pair, const Separation& s, double tolerance) {
  expect_certified(pair, s, tolerance, tolerance);
}

/// The witnesses face each other along the normal.
inline void expect_aligned(const Separation& s, double tolerance) {
  EXPECT_LE((s.p_WA - s.p_WB - s.distance * s.normal_W).norm(), tolerance) << "distance " << s.distance;
}

}  // namespace modsearch::separation_checks
