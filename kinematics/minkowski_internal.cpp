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

/// Beside the axis of a disk a Newton step is too long by the square of (angle to the axis / tilt of the disks).
constexpr int kHalvings = 20;

/// Bit i: segment i points against n.
unsigned signs(const Difference& d, const Vector3d& n) {
  unsigned bits = 0;
  for (int i = 0; i < d.n_segments; ++i) bits |= (n.dot(d.direction[i]) < 0.0 ? 1U : 0U) << i;
  return bits;
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
    if (!(gu * du + gv * dv > 1e-17 * d.scale())) break;  // nothing left to gain
    double scale = std::min(1.0, 0.3 / length);
    bool better = false;
    for (int halving = 0; halving < kHalvings && !better; ++halving, scale *= 0.5) {
      const Vector3d next = (n + scale * (du * u + dv * v)).normalized();
      if (halving >= 4 && signs(d, next) != signs(d, n)) return n;  // ends on an arc
      const double next_value = separation_along(d, next);
      if (next_value > value) {
        n = next;
        value = next_value;
        better = true;
      }
    }
    if (!better) break;
  }
  return n;
}

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

/// Root of `f` between `low`, where it is positive, and `high`, where it is negative. False position, halved whenever
/// the bracket shrinks too slowly: phi bends sharply beside the axis of a disk.
template <class F>
double falling_root(const F& f, double low, double f_low, double high, double f_high) {
  for (int step = 0; step < 120 && high - low > 1e-15; ++step) {
    const double width = high - low;
    const double inside = 0.05 * width;
    double middle = low + width * f_low / (f_low - f_high);
    middle = step % 3 == 2 ? 0.5 * (low + high) : std::clamp(middle, low + inside, high - inside);
    const double value = f(middle);
    if (value == 0.0) return middle;
    if (value > 0.0) {
      low = middle;
      f_low = value;
    } else {
      high = middle;
      f_high = value;
    }
  }
  return 0.5 * (low + high);
}

/// phi on one smooth piece of an arc, in the coordinates (x, y) of the plane of the arc: a linear part and disks seen
/// obliquely, which are ellipses.
struct Piece {
  double wx = 0.0;
  double wy = 0.0;
  int n_disks = 0;
  std::array<double, Difference::kMaxDisks> ax{};
  std::array<double, Difference::kMaxDisks> ay{};
  std::array<double, Difference::kMaxDisks> out_squared{};  ///< of the component of the axis out of the plane
  std::array<double, Difference::kMaxDisks> radius{};

  [[nodiscard]] double sine(int j, double x, double y) const {
    const double across = ax[j] * y - ay[j] * x;
    return std::sqrt(std::max(across * across + out_squared[j], 1e-30));
  }
  [[nodiscard]] double slope(double x, double y) const {
    double value = wy * x - wx * y;
    for (int j = 0; j < n_disks; ++j) {
      value += radius[j] * (ax[j] * x + ay[j] * y) * (ay[j] * x - ax[j] * y) / sine(j, x, y);
    }
    return value;
  }
};

/// The point of the half circle (cos, sin), -90 deg <= angle <= 90 deg, with the tangent of the half angle `t`.
std::array<double, 2> on_half_circle(double t) {
  const double scale = 1.0 / (1.0 + t * t);
  return {(1.0 - t * t) * scale, 2.0 * t * scale};
}

/// Offers local maxima of phi among the unit vectors at right angles to segment `i`.
///
/// The half circle towards c is cut where another segment changes sign and where a disk is seen most obliquely: within
/// a piece phi is smooth and each disk shows one quadrant of its ellipse, so that few sign changes of the slope can
/// occur.
void offer_arc(const Difference& d, int i, Best& best) {
  const Vector3d& g = d.direction[i];
  Vector3d middle = d.c - d.c.dot(g) * g;
  const double length = middle.norm();
  middle = length > 1e-12 * d.scale() ? Vector3d(middle / length) : any_perpendicular(g);
  const Vector3d tangent = g.cross(middle);
  best.offer(d, middle);  // what remains where everything else on the arc is equal
  std::array<double, 2 + Difference::kMaxSegments + Difference::kMaxDisks> cut;
  cut.fill(1.0);
  cut[0] = -1.0;
  int n_cuts = 1;
  const auto cut_at = [&](double x, double y) {
    const double norm = std::hypot(x, y);
    if (norm * norm < kParallel) return;
    const double turned = x < 0.0 ? -1.0 : 1.0;
    cut[n_cuts++] = turned * y / (norm + turned * x);
  };
  std::array<double, Difference::kMaxSegments> gx{};
  std::array<double, Difference::kMaxSegments> gy{};
  for (int k = 0; k < d.n_segments; ++k) {
    if (k == i) continue;
    gx[k] = d.direction[k].dot(middle);
    gy[k] = d.direction[k].dot(tangent);
    cut_at(-gy[k], gx[k]);
  }
  Piece piece;
  piece.n_disks = d.n_disks;
  for (int j = 0; j < d.n_disks; ++j) {
    piece.ax[j] = d.axis[j].dot(middle);
    piece.ay[j] = d.axis[j].dot(tangent);
    piece.out_squared[j] = g.dot(d.axis[j]) * g.dot(d.axis[j]);
    piece.radius[j] = d.radius[j];
    cut_at(piece.ax[j], piece.ay[j]);
  }
  std::sort(cut.begin(), cut.end());
  for (int m = 0; m < n_cuts; ++m) {
    const double width = cut[m + 1] - cut[m];
    if (width < 1e-12) continue;
    const auto [x, y] = on_half_circle(0.5 * (cut[m] + cut[m + 1]));
    piece.wx = d.c.dot(middle);
    piece.wy = d.c.dot(tangent);
    for (int k = 0; k < d.n_segments; ++k) {
      const double half = gx[k] * x + gy[k] * y < 0.0 ? -d.half[k] : d.half[k];
      piece.wx -= half * gx[k];
      piece.wy -= half * gy[k];
    }
    const double low = cut[m] + 1e-10 * width;
    const double high = cut[m + 1] - 1e-10 * width;
    const auto first = on_half_circle(low);
    const auto last = on_half_circle(high);
    // No value in the piece is above its linear part less the smallest ellipse support, which lies at an end.
    double bound = std::hypot(piece.wx, piece.wy);
    if (piece.wy * first[0] < piece.wx * first[1] || piece.wy * last[0] > piece.wx * last[1]) {
      bound = std::max(piece.wx * first[0] + piece.wy * first[1], piece.wx * last[0] + piece.wy * last[1]);
    }
    for (int j = 0; j < d.n_disks; ++j) {
      bound -= d.radius[j] * std::min(piece.sine(j, first[0], first[1]), piece.sine(j, last[0], last[1]));
    }
    if (bound <= best.value) continue;
    constexpr int kParts = 4;
    double before = low;
    double slope_before = piece.slope(first[0], first[1]);
    for (int part = 1; part <= kParts; ++part) {
      const double after = part == kParts ? high : low + (high - low) * part / kParts;
      const auto here = on_half_circle(after);
      const double slope_after = piece.slope(here[0], here[1]);
      if (slope_before >= 0.0 && slope_after <= 0.0) {
        const auto slope_at = [&](double s) {
          const auto at = on_half_circle(s);
          return piece.slope(at[0], at[1]);
        };
        const double t = slope_before == 0.0  ? before
                         : slope_after == 0.0 ? after
                                              : falling_root(slope_at, before, slope_before, after, slope_after);
        const auto at = on_half_circle(t);
        best.offer(d, at[0] * middle + at[1] * tangent);
      }
      before = after;
      slope_before = slope_after;
    }
  }
}

/// Offers maxima where the rims of two disks meet, from evenly spread starting directions and, as phi bends sharply
/// beside the axes, from between them.
void offer_rims(const Difference& d, const Vector3d& guess, Best& best) {
  best.offer(d, climb_sphere(d, best.normal));
  best.offer(d, climb_sphere(d, towards(guess, d.c)));
  constexpr int kStarts = 32;
  constexpr int kClimbs = 3;
  std::array<std::pair<double, Vector3d>, kStarts> start;
  for (int k = 0; k < kStarts; ++k) {  // a spiral of golden angles over the half sphere
    const double z = (k + 0.5) / kStarts;
    const double rho = std::sqrt(1.0 - z * z);
    const double angle = 2.399963229728653 * k;
    const Vector3d n = towards(Vector3d(rho * std::cos(angle), rho * std::sin(angle), z), d.c);
    start[k] = {separation_along(d, n), n};
  }
  std::partial_sort(start.begin(), start.begin() + kClimbs, start.end(),
                    [](const auto& one, const auto& other) { return one.first > other.first; });
  for (int k = 0; k < kClimbs; ++k) best.offer(d, climb_sphere(d, start[k].second));
  if (d.axis[0].cross(d.axis[1]).norm() > 0.2) return;
  const Vector3d other = towards(d.axis[1], d.axis[0]);
  for (const double share : {0.1, 0.5, 0.9}) {
    best.offer(d, climb_sphere(d, towards((share * d.axis[0] + (1.0 - share) * other).normalized(), d.c)));
  }
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
