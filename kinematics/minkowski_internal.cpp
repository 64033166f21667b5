#include "minkowski_internal.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "closed_form_internal.hpp"
#include "direction_search_internal.hpp"
#include "gjk_internal.hpp"

namespace modsearch::detail {
namespace {

using Eigen::Vector3d;

/// Chooses the point of the face with normal `n` that is nearest to distance * n, fills the witness points and `upper`.
///
/// The face is a sum of the segments at right angles to n and the disks facing along n: a point, a stretch or a flat
/// patch, in which the point is found by a descent in the plane. Returns the length of what is left over [m], 0 if the
/// normal is right.
double place_witnesses(const Difference& d, DifferenceResult& result, double flat_below = kFlat) {
  const Vector3d& n = result.normal;
  result.on_a.setZero();
  result.on_b.setZero();
  Vector3d miss = d.c - result.distance * n;
  const auto put = [&](bool of_a, const Vector3d& move) {
    if (of_a) {
      result.on_a += move;
    } else {
      result.on_b -= move;
    }
    miss += move;
  };
  Difference face;  // what is flat, in the coordinates (x, y, n), where z stays exactly zero
  std::array<int, Difference::kMaxSegments> flat{};
  int flat_disk = -1;
  for (int i = 0; i < d.n_segments; ++i) {
    const double along = n.dot(d.direction[i]);
    if (std::abs(along) > flat_below) {
      put(d.segment_of_a[i], (along < 0.0 ? d.half[i] : -d.half[i]) * d.direction[i]);
    } else if (d.half[i] > 0.0) {
      flat[face.n_segments] = i;
      face.add_segment(d.direction[i], d.half[i], d.segment_of_a[i]);
    }
  }
  for (int j = 0; j < d.n_disks; ++j) {
    const Vector3d across = n - n.dot(d.axis[j]) * d.axis[j];
    const double sine = across.norm();
    if (sine > flat_below) {
      put(d.disk_of_a[j], (-d.radius[j] / sine) * across);
    } else if (d.radius[j] > 0.0) {
      flat_disk = j;
      face.add_disk(Vector3d::UnitZ(), d.radius[j], d.disk_of_a[j]);
    }
  }
  if (face.n_segments == 1 && face.n_disks == 0) {
    const int i = flat[0];
    put(d.segment_of_a[i], std::clamp(-miss.dot(d.direction[i]), -d.half[i], d.half[i]) * d.direction[i]);
  } else if (face.n_segments == 0 && face.n_disks == 1) {
    Vector3d move = n.dot(miss) * n - miss;
    const double length = move.norm();
    if (length > d.radius[flat_disk]) move *= d.radius[flat_disk] / length;
    put(d.disk_of_a[flat_disk], move);
  } else if (face.n_segments + face.n_disks > 1) {
    const Vector3d x = any_perpendicular(n);
    const Vector3d y = n.cross(x);
    face.c = Vector3d(miss.dot(x), miss.dot(y), 0.0);
    for (int k = 0; k < face.n_segments; ++k) {
      face.direction[k] = Vector3d(face.direction[k].dot(x), face.direction[k].dot(y), 0.0);
    }
    Descent descent(face, face.c);
    while (descent.step() == Descent::State::kGoing) continue;
    Vector3d on_a = Vector3d::Zero();
    Vector3d on_b = Vector3d::Zero();
    add_witnesses(face, descent.simplex(), on_a, on_b);
    result.on_a += on_a.x() * x + on_a.y() * y;
    result.on_b += on_b.x() * x + on_b.y() * y;
    miss = descent.nearest().x() * x + descent.nearest().y() * y;
  }
  result.upper = result.distance > 0.0 ? (result.distance * n + miss).norm() : result.distance;
  return miss.norm();
}

/// The same for a normal that no family takes exactly, which is so where bodies are tilted by less than a millionth:
/// takes such tilts for flat if that brings the witnesses nearer to each other.
double place_witnesses_somehow(const Difference& d, DifferenceResult& result) {
  double least = place_witnesses(d, result);
  for (const double flat_below : {1e-7, 1e-5, 1e-3}) {
    if (least <= flat_below * 1e-2 * d.scale()) break;
    DifferenceResult other = result;
    const double miss = place_witnesses(d, other, flat_below);
    if (miss >= least) continue;
    least = miss;
    result = other;
  }
  return least;
}

/// The direction of the family that the last simplex of the descent points at: the segments whose sign it mixes are at
/// right angles to the normal.
Vector3d settle(const Difference& d, const Vector3d& n, const Simplex& simplex) {
  for (int j = 0; j < d.n_disks; ++j) {
    for (int k = 1; k < simplex.size; ++k) {
      if (simplex.vertex[k].rim[j].dot(simplex.vertex[0].rim[j]) < 0.0)
        return n.dot(d.axis[j]) < 0.0 ? -d.axis[j] : d.axis[j];
    }
  }
  unsigned mixed = 0;
  for (int k = 1; k < simplex.size; ++k) mixed |= simplex.vertex[k].signs ^ simplex.vertex[0].signs;
  const Vector3d* first = nullptr;
  for (int i = 0; i < d.n_segments; ++i) {
    if ((mixed >> i & 1U) == 0U) continue;
    if (first == nullptr) {
      first = &d.direction[i];
      continue;
    }
    const Vector3d across = first->cross(d.direction[i]);
    const double squared = across.squaredNorm();
    if (squared > kParallel) return (n.dot(across) < 0.0 ? -1.0 : 1.0) / std::sqrt(squared) * across;
  }
  if (first == nullptr) return climb_sphere(d, n);
  const Vector3d on_arc = n - n.dot(*first) * *first;
  const double length = on_arc.norm();
  if (length < 0.5) return n;  // far from the arc: not settled yet
  return climb_arc(d, *first, on_arc / length);
}

DifferenceResult overlapping(const Difference& d, const Vector3d& guess) {
  Best best;
  offer_corners(d, best);
  if (d.n_disks > 0) {
    for (int i = 0; i < d.n_segments; ++i) offer_arc(d, i, best);
  }
  if (d.n_disks > 1) offer_rims(d, guess, best);
  DifferenceResult result;
  result.distance = best.value;
  result.normal = best.normal;
  place_witnesses_somehow(d, result);
  result.upper = result.distance;
  return result;
}

}  // namespace

void Difference::add_segment(const Vector3d& unit, double half_length, bool of_a) {
  direction[n_segments] = unit;
  half[n_segments] = half_length;
  segment_of_a[n_segments++] = of_a;
}

void Difference::add_disk(const Vector3d& unit_normal, double disk_radius, bool of_a) {
  axis[n_disks] = unit_normal;
  radius[n_disks] = disk_radius;
  disk_of_a[n_disks++] = of_a;
}

void Difference::add_triangle(const std::array<Vector3d, 3>& triangle, bool of_a) {
  corners[n_triangles] = triangle;
  triangle_of_a[n_triangles++] = of_a;
}

double Difference::scale() const {
  double sum = c.norm();
  for (int i = 0; i < n_segments; ++i) sum += half[i];
  for (int j = 0; j < n_disks; ++j) sum += radius[j];
  return sum;
}

double separation_along(const Difference& d, const Vector3d& n) {
  double value = n.dot(d.c);
  for (int i = 0; i < d.n_segments; ++i) value -= d.half[i] * std::abs(n.dot(d.direction[i]));
  for (int j = 0; j < d.n_disks; ++j) value -= d.radius[j] * n.cross(d.axis[j]).norm();
  for (int t = 0; t < d.n_triangles; ++t) {
    const auto& [p, q, r] = d.corners[t];
    const double sign = d.triangle_of_a[t] ? 1.0 : -1.0;
    value += std::min({sign * n.dot(p), sign * n.dot(q), sign * n.dot(r)});
  }
  return value;
}

DifferenceResult signed_difference(const Difference& d, const Vector3d& guess) {
  const double scale = d.scale();
  Descent descent(d, guess);
  Best best;
  double try_below = 0.05;
  while (true) {
    const Descent::State state = descent.step();
    if (state == Descent::State::kOverlap) break;
    const bool last = state == Descent::State::kStalled;
    const double gap = descent.upper() - descent.lower();
    if (descent.lower() > 0.0 && (last || gap <= try_below * descent.upper())) {
      DifferenceResult result;
      const Vector3d n = settle(d, descent.normal(), descent.simplex());
      result.normal = n;
      result.distance = separation_along(d, n);
      if (place_witnesses(d, result) <= 1e-11 * scale && result.distance > 0.0) return result;
      best.offer(d, n);
      best.offer(d, descent.normal());
      try_below *= 0.03;
    }
    if (last) break;
  }
  // Touching to rounding, overlapping, or a normal that no family took: search them all, keep the best.
  DifferenceResult result = overlapping(d, descent.normal());
  if (best.value > result.distance) {
    result.normal = best.normal;
    result.distance = best.value;
    place_witnesses_somehow(d, result);
  }
  if (result.distance <= 0.0) return result;
  result.upper = std::min(result.upper, descent.upper());
  const double miss = (d.c + result.on_a - result.on_b - result.distance * result.normal).norm();
  if ((descent.nearest() - result.distance * descent.normal()).norm() < miss &&
      separation_along(d, descent.normal()) > result.distance - 1e-9 * scale) {
    result.normal = descent.normal();
    result.on_a.setZero();
    result.on_b.setZero();
    add_witnesses(d, descent.simplex(), result.on_a, result.on_b);
  }
  return result;
}

bool difference_overlaps(const Difference& d, const Vector3d& guess) {
  Descent descent(d, guess);
  while (true) {
    const Descent::State state = descent.step();
    if (descent.lower() > 0.0) return false;
    if (state == Descent::State::kOverlap) return true;
    if (state == Descent::State::kStalled) return overlapping(d, descent.normal()).distance < 0.0;
  }
}

}  // namespace modsearch::detail
