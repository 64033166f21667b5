#include "gjk_internal.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace modsearch::detail {
namespace {

using Eigen::Vector3d;

/// Nearest point of a simplex to the origin and the weights of the vertices in it.
struct Nearest {
  Vector3d point = Vector3d::Zero();
  std::array<double, 4> weight{};
};

Nearest nearest_on_vertex(const Simplex& s, int i) {
  Nearest result;
  result.point = s.vertex[i].point;
  result.weight[i] = 1.0;
  return result;
}

Nearest nearest_on_edge(const Simplex& s, int i, int j) {
  const Vector3d& a = s.vertex[i].point;
  const Vector3d ab = s.vertex[j].point - a;
  const double along = -a.dot(ab);
  const double squared = ab.squaredNorm();
  if (along <= 0.0) return nearest_on_vertex(s, i);
  if (along >= squared) return nearest_on_vertex(s, j);
  Nearest result;
  const double t = along / squared;
  result.point = a + t * ab;
  result.weight[i] = 1.0 - t;
  result.weight[j] = t;
  return result;
}

Nearest nearest_on_triangle(const Simplex& s, int i, int j, int k) {
  const Vector3d& a = s.vertex[i].point;
  const Vector3d& b = s.vertex[j].point;
  const Vector3d& c = s.vertex[k].point;
  const Vector3d normal = (b - a).cross(c - a);
  const double squared = normal.squaredNorm();
  // Twice the signed areas of the triangles that the projected origin forms with the edges.
  const double ab = normal.dot(a.cross(b));
  const double bc = normal.dot(b.cross(c));
  const double ca = normal.dot(c.cross(a));
  Nearest best;
  double best_squared = std::numeric_limits<double>::infinity();
  const auto offer = [&](const Nearest& candidate) {
    const double value = candidate.point.squaredNorm();
    if (value < best_squared) {
      best_squared = value;
      best = candidate;
    }
  };
  // The normal of a sliver is mostly rounding: then the edges are asked too.
  const bool sliver = squared <= 1e-12 * (b - a).squaredNorm() * (c - a).squaredNorm();
  if (ab > 0.0 && bc > 0.0 && ca > 0.0) {
    // As a combination of the corners the point cannot leave the triangle, however poor the normal is.
    Nearest inside;
    const double sum = ab + bc + ca;
    inside.weight[i] = bc / sum;
    inside.weight[j] = ca / sum;
    inside.weight[k] = ab / sum;
    inside.point = inside.weight[i] * a + inside.weight[j] * b + inside.weight[k] * c;
    if (!sliver) return inside;
    offer(inside);
  }
  if (sliver || !(ab > 0.0)) offer(nearest_on_edge(s, i, j));
  if (sliver || !(bc > 0.0)) offer(nearest_on_edge(s, j, k));
  if (sliver || !(ca > 0.0)) offer(nearest_on_edge(s, k, i));
  return best;
}

/// Whether the origin and vertex `apex` lie on different sides of the plane through the other three, or the tetrahedron
/// is too flat to tell.
bool outside_face(const Simplex& s, int i, int j, int k, int apex) {
  const Vector3d& a = s.vertex[i].point;
  const Vector3d normal = (s.vertex[j].point - a).cross(s.vertex[k].point - a);
  const double of_apex = normal.dot(s.vertex[apex].point - a);
  const double of_origin = -normal.dot(a);
  const double flat = 1e-8 * std::sqrt(normal.squaredNorm() * (s.vertex[apex].point - a).squaredNorm());
  if (std::abs(of_apex) <= flat) return true;
  return of_apex > 0.0 ? of_origin < 0.0 : of_origin > 0.0;
}

/// Nearest point of the four faces that the origin is outside of; `inside` if there is none.
Nearest nearest_on_tetrahedron(const Simplex& s, bool& inside) {
  constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
  Nearest best;
  double best_squared = std::numeric_limits<double>::infinity();
  inside = true;
  for (const auto& face : kFaces) {
    if (!outside_face(s, face[0], face[1], face[2], face[3])) continue;
    inside = false;
    const Nearest candidate = nearest_on_triangle(s, face[0], face[1], face[2]);
    const double value = candidate.point.squaredNorm();
    if (value < best_squared) {
      best_squared = value;
      best = candidate;
    }
  }
  return best;
}

Nearest nearest_on(const Simplex& s, bool& inside) {
  inside = false;
  switch (s.size) {
    case 1:
      return nearest_on_vertex(s, 0);
    case 2:
      return nearest_on_edge(s, 0, 1);
    case 3:
      return nearest_on_triangle(s, 0, 1, 2);
    default:
      return nearest_on_tetrahedron(s, inside);
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
  for (int t = 0; t < d.n_triangles; ++t) {
    const double sign = d.triangle_of_a[t] ? 1.0 : -1.0;
    for (int k = 1; k < 3; ++k) {
      if (sign * n.dot(d.corners[t][k] - d.corners[t][result.corner[t]]) < 0.0) result.corner[t] = k;
    }
    result.point += sign * d.corners[t][result.corner[t]];
  }
  return result;
}

void add_witnesses(const Difference& d, const Simplex& simplex, Vector3d& on_a, Vector3d& on_b) {
  // A - B holds B mirrored: what the difference adds for B, B itself subtracts.
  const auto put = [&](bool of_a, const Vector3d& move) {
    if (of_a) {
      on_a += move;
    } else {
      on_b -= move;
    }
  };
  for (int k = 0; k < simplex.size; ++k) {
    const Vertex& vertex = simplex.vertex[k];
    const double weight = simplex.weight[k];
    for (int i = 0; i < d.n_segments; ++i) {
      const bool positive = (vertex.signs >> i & 1U) != 0U;
      put(d.segment_of_a[i], (positive ? weight : -weight) * d.half[i] * d.direction[i]);
    }
    for (int j = 0; j < d.n_disks; ++j) put(d.disk_of_a[j], weight * d.radius[j] * vertex.rim[j]);
    for (int t = 0; t < d.n_triangles; ++t) {
      const double sign = d.triangle_of_a[t] ? 1.0 : -1.0;
      put(d.triangle_of_a[t], sign * weight * d.corners[t][vertex.corner[t]]);
    }
  }
}

Descent::Descent(const Difference& d, const Vector3d& guess) : d_(d) {
  const double length = guess.norm();
  normal_ = length > 0.0 ? Vector3d(guess / length) : Vector3d(Vector3d::UnitZ());
  simplex_.vertex[0] = lowest(d, normal_);
  simplex_.size = 1;
  simplex_.weight[0] = 1.0;
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
  // Neighbours on a rim this close differ by rounding only, and a simplex of them has no meaningful normal.
  for (int k = 0; k < simplex_.size; ++k) {
    if ((vertex.point - simplex_.vertex[k].point).squaredNorm() <= 1e-16 * largest_) return State::kStalled;
  }
  simplex_.vertex[simplex_.size++] = vertex;
  largest_ = std::max(largest_, vertex.point.squaredNorm());
  bool inside = false;
  const Nearest nearest = nearest_on(simplex_, inside);
  if (inside) return State::kOverlap;
  const double next = nearest.point.norm();
  if (next >= upper_) {
    --simplex_.size;
    return State::kStalled;
  }
  int kept = 0;
  for (int k = 0; k < simplex_.size; ++k) {
    if (nearest.weight[k] <= 0.0) continue;
    if (kept != k) simplex_.vertex[kept] = simplex_.vertex[k];
    simplex_.weight[kept++] = nearest.weight[k];
  }
  simplex_.size = kept;
  nearest_ = nearest.point;
  upper_ = next;
  if (upper_ > 0.0) normal_ = nearest_ / upper_;
  return State::kGoing;
}

}  // namespace modsearch::detail
