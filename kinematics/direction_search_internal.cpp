#include "direction_search_internal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "closed_form_internal.hpp"

namespace modsearch::detail {
namespace {

using Eigen::Vector3d;

/// Turns `n` so that it does not point against `c`; by symmetry that is the better of the two.
Vector3d towards(const Vector3d& n, const Vector3d& c) { return n.dot(c) < 0.0 ? Vector3d(-n) : n; }

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

/// Beside the axis of a disk a Newton step is too long by the square of (angle to the axis / tilt of the disks).
constexpr int kHalvings = 20;

/// Bit i: segment i points against n.
unsigned signs(const Difference& d, const Vector3d& n) {
  unsigned bits = 0;
  for (int i = 0; i < d.n_segments; ++i) bits |= (n.dot(d.direction[i]) < 0.0 ? 1U : 0U) << i;
  return bits;
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

/// A point between `low` and `high` where `f` is at most zero, or about the least if there is none.
template <class F>
double lowest_between(const F& f, double low, double high) {
  constexpr double kGolden = 0.6180339887498949;
  double left = high - kGolden * (high - low);
  double right = low + kGolden * (high - low);
  double f_left = f(left);
  double f_right = f(right);
  for (int step = 0; step < 16 && f_left > 0.0 && f_right > 0.0; ++step) {
    if (f_left <= f_right) {
      high = right;
      right = left;
      f_right = f_left;
      left = high - kGolden * (high - low);
      f_left = f(left);
    } else {
      low = left;
      left = right;
      f_left = f_right;
      right = low + kGolden * (high - low);
      f_right = f(right);
    }
  }
  return f_left <= f_right ? left : right;
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

/// Calls `offer` with the local maxima of phi on the piece from `low` to `high`: where the slope falls through zero.
///
/// Samples crowd at both ends, where phi may bend within a small angle. Where three samples come near zero without
/// passing it, a golden search looks for a maximum and a minimum between them.
template <class Offer>
void offer_maxima(const Piece& piece, double low, double high, const Offer& offer) {
  constexpr int kSamples = 9;
  constexpr std::array<double, kSamples> kShare{0.0,      0.038060, 0.146447, 0.308658, 0.5,
                                                0.691342, 0.853553, 0.961940, 1.0};  // (1 - cos(k 22.5 deg)) / 2
  const auto slope_at = [&](double t) {
    const auto at = on_half_circle(t);
    return piece.slope(at[0], at[1]);
  };
  const auto offer_between = [&](double before, double slope_before, double after, double slope_after) {
    if (slope_before < 0.0 || slope_after > 0.0) return;
    if (slope_before == 0.0 || slope_after == 0.0) {
      offer(slope_before == 0.0 ? before : after);
    } else {
      offer(falling_root(slope_at, before, slope_before, after, slope_after));
    }
  };
  std::array<double, kSamples> t{};
  std::array<double, kSamples> slope{};
  for (std::size_t k = 0; k < kSamples; ++k) {
    t[k] = low + (high - low) * kShare[k];
    slope[k] = slope_at(t[k]);
    if (k > 0) offer_between(t[k - 1], slope[k - 1], t[k], slope[k]);
    if (k < 2) continue;
    const double sign = side(slope[k - 1]);
    const auto height = [&](double value) { return sign * value; };  // positive on all three samples
    if (height(slope[k - 2]) <= 0.0 || height(slope[k]) <= 0.0) continue;
    if (slope[k - 1] == 0.0 || height(slope[k - 1]) > std::min(height(slope[k - 2]), height(slope[k]))) continue;
    const double passed = lowest_between([&](double x) { return height(slope_at(x)); }, t[k - 2], t[k]);
    const double slope_passed = slope_at(passed);
    if (height(slope_passed) > 0.0) continue;
    offer_between(t[k - 2], slope[k - 2], passed, slope_passed);
    offer_between(passed, slope_passed, t[k], slope[k]);
  }
}

}  // namespace

Vector3d any_perpendicular(const Vector3d& unit) {
  int axis = 0;
  unit.cwiseAbs().minCoeff(&axis);
  return unit.cross(Vector3d::Unit(axis)).normalized();
}

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
    offer_maxima(piece, low, high, [&](double t) {
      const auto at = on_half_circle(t);
      best.offer(d, at[0] * middle + at[1] * tangent);
    });
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

}  // namespace modsearch::detail
