#include "gjk_internal.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace modsearch::detail {
namespace {

using Eigen::Vector3d;

/// Nearest point of a simplex to the origin and the vertices that carry it, as bits.
struct Nearest {
  Vector3d point;
  unsigned used;
};

Nearest nearest_on_edge(const Simplex& s, int i, int j) {
  const Vector3d& a = s.vertex[i].point;
  const Vector3d ab = s.vertex[j].point - a;
  const double t = -a.dot(ab);
  const double squared = ab.squaredNorm();
  if (t <= 0.0) return {a, 1U << i};
  if (t >= squared) return {s.vertex[j].point, 1U << j};
  return {a + t / squared * ab, 1U << i | 1U << j};
}

Nearest nearest_on_triangle(const Simplex& s, int i, int j, int k) {
  const Vector3d& a = s.vertex[i].point;
  const Vector3d& b = s.vertex[j].point;
  const Vector3d& c = s.vertex[k].point;
  const Vector3d normal = (b - a).cross(c - a);
  const double squared = normal.squaredNorm();
  // The projection is inside where the origin is on the inner side of all three edges.
  const bool ab = normal.dot((b - a).cross(-a)) > 0.0;
  const bool bc = normal.dot((c - b).cross(-b)) > 0.0;
  const bool ca = normal.dot((a - c).cross(-c)) > 0.0;
  if (ab && bc && ca) return {normal.dot(a) / squared * normal, 1U << i | 1U << j | 1U << k};
  Nearest best{a, 1U << i};
  double best_squared = std::numeric_limits<double>::infinity();
  const auto offer = [&](const Nearest& candidate) {
    const double value = candidate.point.squaredNorm();
    if (value < best_squared) {
      best_squared = value;
      best = candidate;
    }
  };
  if (!ab) offer(nearest_on_edge(s, i, j));
  if (!bc) offer(nearest_on_edge(s, j, k));
  if (!ca) offer(nearest_on_edge(s, k, i));
  return best;
}

/// Whether the origin and vertex `apex` lie on different sides of the plane through the other three.
bool outside_face(const Simplex& s, int i, int j, int k, int apex) {
  const Vector3d& a = s.vertex[i].point;
  const Vector3d normal = (s.vertex[j].point - a).cross(s.vertex[k].point - a);
  const double of_apex = normal.dot(s.vertex[apex].point - a);
  const double of_origin = -normal.dot(a);
  return of_apex > 0.0 ? of_origin < 0.0 : of_origin > 0.0 || of_apex == 0.0;
}

Nearest nearest_on_tetrahedron(const Simplex& s) {
  constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
  Nearest best{Vector3d::Zero(), 15U};
  double best_squared = std::numeric_limits<double>::infinity();
  for (const auto& face : kFaces) {
    if (!outside_face(s, face[0], face[1], face[2], face[3])) continue;
    const Nearest candidate = nearest_on_triangle(s, face[0], face[1], face[2]);
    const double value = candidate.point.squaredNorm();
    if (value < best_squared) {
      best_squared = value;
      best = candidate;
    }
  }
  return best;
}

Nearest nearest_on(const Simplex& s) {
  switch (s.size) {
    case 1:
      return {s.vertex[0].point, 1U};
    case 2:
      return nearest_on_edge(s, 0, 1);
    case 3:
      return nearest_on_triangle(s, 0, 1, 2);
    default:
      return nearest_on_tetrahedron(s);
  }
}

}  // namespace

Vertex lowest(const Difference& d, const Vector3d& n) {
  Vertex result;
  result.point = d.c;
  for (int i = 0; i < d.n_segments; ++i) {
    const bool positive = n.dot(d.direction[i]) < 0.0;
    result.point += (positive ? d.half[i] : -d.half[i]) * d.direction[i];
    if (positive) result.signs |= 1U << i;
  }
  for (int j = 0; j < d.n_disks; ++j) {
    const Vector3d across = n.dot(d.axis[j]) * d.axis[j] - n;
    const double sine = across.norm();
    result.rim[j] = sine > 1e-12 ? Vector3d(across / sine) : Vector3d(Vector3d::Zero());
    result.point += d.radius[j] * result.rim[j];
  }
  return result;
}

Descent::Descent(const Difference& d, const Vector3d& guess) : d_(d) {
  const double length = guess.norm();
  normal_ = length > 0.0 ? Vector3d(guess / length) : Vector3d(Vector3d::UnitZ());
  simplex_.vertex[0] = lowest(d, normal_);
  simplex_.size = 1;
  nearest_ = simplex_.vertex[0].point;
  largest_ = nearest_.squaredNorm();
  lower_ = normal_.dot(nearest_);
  upper_ = std::sqrt(largest_);
  if (upper_ > 0.0) normal_ = nearest_ / upper_;
}

Descent::State Descent::step() {
  constexpr int kMaxSteps = 100;  // seen: 25 at most; a limit only against cycling by rounding
  if (upper_ * upper_ <= 1e-26 * largest_) return State::kOverlap;
  if (++steps_ > kMaxSteps) return State::kStalled;
  const Vertex vertex = lowest(d_, normal_);
  lower_ = std::max(lower_, normal_.dot(vertex.point));
  if (upper_ - normal_.dot(vertex.point) <= 1e-15 * std::sqrt(largest_)) return State::kStalled;
  simplex_.vertex[simplex_.size++] = vertex;
  largest_ = std::max(largest_, vertex.point.squaredNorm());
  const Nearest nearest = nearest_on(simplex_);
  if (nearest.used == 15U) return State::kOverlap;
  const double next = nearest.point.norm();
  if (next >= upper_) {
    --simplex_.size;
    return State::kStalled;
  }
  int kept = 0;
  for (int k = 0; k < simplex_.size; ++k) {
    if ((nearest.used >> k & 1U) == 0U) continue;
    if (kept != k) simplex_.vertex[kept] = simplex_.vertex[k];
    ++kept;
  }
  simplex_.size = kept;
  nearest_ = nearest.point;
  upper_ = next;
  if (upper_ > 0.0) normal_ = nearest_ / upper_;
  return State::kGoing;
}

}  // namespace modsearch::detail
