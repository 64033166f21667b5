#include "minkowski_internal.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "closed_form_internal.hpp"
#include "gjk_internal.hpp"

namespace modsearch::detail {
namespace {

using Eigen::Vector3d;

/// A segment counts as at right angles to n, and a disk as facing along n, below this sine; normals found within a
/// family meet it to rounding.
constexpr double kFlat = 1e-9;

Vector3d any_perpendicular(const Vector3d& unit) {
  int axis = 0;
  unit.cwiseAbs().minCoeff(&axis);
  return unit.cross(Vector3d::Unit(axis)).normalized();
}

/// Turns `n` so that it does not point against `c`; by symmetry that is the better of the two.
Vector3d towards(const Vector3d& n, const Vector3d& c) { return n.dot(c) < 0.0 ? Vector3d(-n) : n; }

/// The best direction so far.
struct Best {
  double value = -std::numeric_limits<double>::infinity();
  Vector3d normal = Vector3d::UnitZ();

  bool offer(const Difference& d, const Vector3d& n) {
    const double candidate = separation_along(d, n);
    if (!(candidate > value)) return false;
    value = candidate;
    normal = n;
    return true;
  }
};

/// Gradient of phi in n with every segment at right angles to n left out: the centre of the face of the difference.
Vector3d face_centre(const Difference& d, const Vector3d& n, double flat) {
  Vector3d w = d.c;
  for (int i = 0; i < d.n_segments; ++i) {
    const double along = n.dot(d.direction[i]);
    if (std::abs(along) > flat) w -= (along < 0.0 ? -d.half[i] : d.half[i]) * d.direction[i];
  }
  for (int j = 0; j < d.n_disks; ++j) {
    const Vector3d across = n - n.dot(d.axis[j]) * d.axis[j];
    const double sine = across.norm();
    if (sine > flat) w -= (d.radius[j] / sine) * across;
  }
  return w;
}

/// Climbs phi on the arc of unit vectors at right angles to `g`, from `n` on it.
Vector3d climb_arc(const Difference& d, const Vector3d& g, Vector3d n) {
  double value = separation_along(d, n);
  for (int step = 0; step < 12; ++step) {
    const Vector3d tangent = g.cross(n);
    const double slope = tangent.dot(face_centre(d, n, kFlat));
    double curvature = -value;
    for (int j = 0; j < d.n_disks; ++j) {
      const double na = n.dot(d.axis[j]);
      const double sine = std::sqrt(std::max(1.0 - na * na, 1e-30));
      const double ta = tangent.dot(d.axis[j]);
      curvature -= d.radius[j] / sine * std::max(0.0, 1.0 - ta * ta / (sine * sine));
    }
    double turn = curvature < 0.0 ? -slope / curvature : std::copysign(0.1, slope);
    turn = std::clamp(turn, -0.3, 0.3);
    bool better = false;
    for (int halving = 0; halving < 6 && !better; ++halving, turn *= 0.5) {
      const Vector3d next = (n + turn * tangent).normalized();
      const double next_value = separation_along(d, next);
      if (next_value > value) {
        n = next;
        value = next_value;
        better = true;
      }
    }
    if (!better || std::abs(turn) < 1e-13) break;
  }
  return n;
}

/// Climbs phi on the whole sphere from `n`, all signs taken as they come.
Vector3d climb_sphere(const Difference& d, Vector3d n) {
  double value = separation_along(d, n);
  for (int step = 0; step < 12; ++step) {
    const Vector3d u = any_perpendicular(n);
    const Vector3d v = n.cross(u);
    const Vector3d gradient = face_centre(d, n, kFlat);
    const double gu = gradient.dot(u);
    const double gv = gradient.dot(v);
    double huu = -value;
    double huv = 0.0;
    double hvv = -value;
    for (int j = 0; j < d.n_disks; ++j) {
      const Vector3d around = d.axis[j].cross(n);  // the only direction in which the support of a disk bends
      const double squared = around.squaredNorm();
      if (squared < 1e-18) continue;
      const double bend = d.radius[j] / (squared * std::sqrt(squared));
      huu -= bend * around.dot(u) * around.dot(u);
      huv -= bend * around.dot(u) * around.dot(v);
      hvv -= bend * around.dot(v) * around.dot(v);
    }
    const double determinant = huu * hvv - huv * huv;
    double du = gu;
    double dv = gv;
    if (huu + hvv < 0.0 && determinant > 1e-12 * (huu + hvv) * (huu + hvv)) {
      du = -(hvv * gu - huv * gv) / determinant;
      dv = -(huu * gv - huv * gu) / determinant;
    }
    const double length = std::hypot(du, dv);
    if (!(length > 0.0)) break;
    double scale = std::min(1.0, 0.3 / length);
    bool better = false;
    for (int halving = 0; halving < 6 && !better; ++halving, scale *= 0.5) {
      const Vector3d next = (n + scale * (du * u + dv * v)).normalized();
      const double next_value = separation_along(d, next);
      if (next_value > value) {
        n = next;
        value = next_value;
        better = true;
      }
    }
    if (!better || scale * length < 1e-13) break;
  }
  return n;
}

/// Chooses the point of the face with normal `n` that is nearest to distance * n, fills the witness points and `upper`.
///
/// The face is a sum of the segments at right angles to n and the disks facing along n, at most a flat patch: descent
/// in one segment or disk at a time ends at once but where several lie flat on each other. Returns the length of what
/// is left over [m], 0 if the normal is right.
double place_witnesses(const Difference& d, DifferenceResult& result) {
  const Vector3d& n = result.normal;
  Vector3d miss = d.c - result.distance * n;
  result.on_a.setZero();
  result.on_b.setZero();
  const auto put = [&](bool of_a, const Vector3d& move) {
    // A - B holds B mirrored; B is symmetric, so its own point is the opposite one.
    if (of_a) {
      result.on_a += move;
    } else {
      result.on_b -= move;
    }
    miss += move;
  };
  std::array<int, Difference::kMaxSegments> flat_segments{};
  std::array<double, Difference::kMaxSegments> at{};
  int n_flat_segments = 0;
  for (int i = 0; i < d.n_segments; ++i) {
    const double along = n.dot(d.direction[i]);
    if (std::abs(along) > kFlat) {
      put(d.segment_of_a[i], (along < 0.0 ? d.half[i] : -d.half[i]) * d.direction[i]);
    } else if (d.half[i] > 0.0) {
      flat_segments[n_flat_segments++] = i;
    }
  }
  std::array<int, Difference::kMaxDisks> flat_disks{};
  std::array<Vector3d, Difference::kMaxDisks> offset;
  int n_flat_disks = 0;
  for (int j = 0; j < d.n_disks; ++j) {
    const Vector3d across = n - n.dot(d.axis[j]) * d.axis[j];
    const double sine = across.norm();
    if (sine > kFlat) {
      put(d.disk_of_a[j], (-d.radius[j] / sine) * across);
    } else if (d.radius[j] > 0.0) {
      offset[n_flat_disks].setZero();
      flat_disks[n_flat_disks++] = j;
    }
  }
  const int sweeps = n_flat_segments + n_flat_disks > 1 ? 400 : n_flat_segments + n_flat_disks;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    double moved = 0.0;
    for (int k = 0; k < n_flat_segments; ++k) {
      const int i = flat_segments[k];
      const double next = std::clamp(at[k] - miss.dot(d.direction[i]), -d.half[i], d.half[i]);
      const double step = next - at[k];
      at[k] = next;
      if (step != 0.0) put(d.segment_of_a[i], step * d.direction[i]);
      moved = std::max(moved, std::abs(step));
    }
    for (int k = 0; k < n_flat_disks; ++k) {
      const int j = flat_disks[k];
      Vector3d next = offset[k] - (miss - miss.dot(d.axis[j]) * d.axis[j]);
      const double length = next.norm();
      if (length > d.radius[j]) next *= d.radius[j] / length;
      const Vector3d step = next - offset[k];
      offset[k] = next;
      put(d.disk_of_a[j], step);
      moved = std::max(moved, step.norm());
    }
    if (moved <= 1e-16 * d.scale()) break;
  }
  const double left = miss.norm();
  result.upper = result.distance > 0.0 ? (result.distance * n + miss).norm() : result.distance;
  return left;
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

/// Offers the directions along disk axes and at right angles to two segments.
void offer_corners(const Difference& d, Best& best) {
  for (int j = 0; j < d.n_disks; ++j) best.offer(d, towards(d.axis[j], d.c));
  for (int i = 0; i < d.n_segments; ++i) {
    for (int k = i + 1; k < d.n_segments; ++k) {
      const Vector3d across = d.direction[i].cross(d.direction[k]);
      const double squared = across.squaredNorm();
      if (squared > kParallel) best.offer(d, towards(across / std::sqrt(squared), d.c));
    }
  }
}

/// Offers local maxima of phi among the unit vectors at right angles to segment `i`.
///
/// The half circle towards c is cut where another segment changes sign; within a piece phi is smooth.
void offer_arc(const Difference& d, int i, Best& best) {
  const Vector3d& g = d.direction[i];
  Vector3d middle = d.c - d.c.dot(g) * g;
  const double length = middle.norm();
  middle = length > 1e-12 * d.scale() ? Vector3d(middle / length) : any_perpendicular(g);
  const Vector3d tangent = g.cross(middle);
  // Cuts by the tangent-like coordinate of the half circle: t = sin / (1 + cos) rises from -1 to 1 along it.
  std::array<double, 2 + Difference::kMaxSegments> cut;
  cut.fill(1.0);
  cut[0] = -1.0;
  int n_cuts = 1;
  for (int k = 0; k < d.n_segments; ++k) {
    if (k == i) continue;
    const Vector3d across = g.cross(d.direction[k]);
    const double sine = across.norm();
    if (sine * sine < kParallel) continue;
    const Vector3d n = towards(across / sine, middle);
    cut[n_cuts++] = n.dot(tangent) / (1.0 + n.dot(middle));
  }
  std::sort(cut.begin(), cut.end());
  const auto direction = [&](double t) {
    return Vector3d(((1.0 - t * t) * middle + 2.0 * t * tangent) / (1.0 + t * t));
  };
  constexpr int kSamples = 6;  // per piece, where phi has at most two maxima
  for (int piece = 0; piece < n_cuts; ++piece) {
    const double low = cut[piece];
    const double width = cut[piece + 1] - low;
    if (width < 1e-9) continue;
    std::array<double, kSamples> value{};
    for (int k = 0; k < kSamples; ++k) value[k] = separation_along(d, direction(low + width * k / (kSamples - 1)));
    for (int k = 0; k < kSamples; ++k) {
      if (k > 0 && value[k - 1] > value[k]) continue;
      if (k + 1 < kSamples && value[k + 1] > value[k]) continue;
      // phi cannot rise faster than its farthest point is away: most samples are hopeless at once.
      const double reach = d.scale() * 2.0 * width / (kSamples - 1);
      if (value[k] + reach < best.value) continue;
      best.offer(d, climb_arc(d, g, direction(low + width * k / (kSamples - 1))));
    }
  }
}

/// Offers maxima where the rims of two disks meet, from evenly spread starting directions.
void offer_rims(const Difference& d, const Vector3d& guess, Best& best) {
  if (guess.squaredNorm() > 0.0) best.offer(d, climb_sphere(d, towards(guess.normalized(), d.c)));
  constexpr int kStarts = 48;
  constexpr int kClimbs = 4;
  std::array<std::pair<double, int>, kStarts> start;
  const auto spread = [](int k) {  // a spiral of golden angles over the half sphere
    const double z = (k + 0.5) / kStarts;
    const double rho = std::sqrt(1.0 - z * z);
    const double angle = 2.399963229728653 * k;
    return Vector3d(rho * std::cos(angle), rho * std::sin(angle), z);
  };
  for (int k = 0; k < kStarts; ++k) start[k] = {-separation_along(d, towards(spread(k), d.c)), k};
  std::partial_sort(start.begin(), start.begin() + kClimbs, start.end());
  for (int k = 0; k < kClimbs; ++k) best.offer(d, climb_sphere(d, towards(spread(start[k].second), d.c)));
  best.offer(d, climb_sphere(d, best.normal));
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
  place_witnesses(d, result);
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
  return value;
}

DifferenceResult signed_difference(const Difference& d, const Vector3d& guess) {
  const double scale = d.scale();
  Descent descent(d, guess);
  Best best;
  double best_upper = std::numeric_limits<double>::infinity();
  double try_below = 0.05;
  while (true) {
    const Descent::State state = descent.step();
    if (state == Descent::State::kOverlap) break;
    best_upper = std::min(best_upper, descent.upper());
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
  // Touching to rounding, overlapping, or a normal that no family took: search them all, keep what was found.
  DifferenceResult result = overlapping(d, descent.normal());
  if (best.value > result.distance) {
    result.normal = best.normal;
    result.distance = best.value;
    place_witnesses(d, result);
  }
  if (result.distance > 0.0) result.upper = std::min(result.upper, best_upper);
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
