#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <modsearch/kinematics/separation.hpp>
#include <type_traits>
#include <variant>

#include "closed_form_internal.hpp"
#include "fcl_backend_internal.hpp"
#include "minkowski_internal.hpp"

// Every pair is written for one order only, by rank: sphere < capsule < cylinder < box < mesh. The public functions
// swap arguments and mirror the answer where needed. A sphere is a rounded point and a capsule a rounded segment: their
// radius is subtracted from the distance of the point or segment, which is exact inside as well as outside.

namespace modsearch {
namespace {

using detail::Difference;
using detail::DifferenceResult;
using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A normal counts as at right angles to an axis below this cosine: over an axis of 1 m the error is 1 pm.
constexpr double kRightAngle = 1e-12;

template <class S>
constexpr int kRank = std::is_same_v<S, Sphere>     ? 0
                      : std::is_same_v<S, Capsule>  ? 1
                      : std::is_same_v<S, Cylinder> ? 2
                      : std::is_same_v<S, Box>      ? 3
                                                    : 4;

Vector3d axis_of(const Isometry3d& X) { return X.linear().col(2); }

/// `p` seen from the frame `X`, without forming the inverse.
Vector3d seen_from(const Isometry3d& X, const Vector3d& p) { return X.linear().transpose() * (p - X.translation()); }

double rounding(const Sphere& sphere) { return sphere.radius; }
double rounding(const Capsule& capsule) { return capsule.radius; }
double rounding(const Cylinder&) { return 0.0; }
double rounding(const Box&) { return 0.0; }

void add(Difference& d, const Capsule& capsule, const Isometry3d& X, bool of_a) {
  d.add_segment(axis_of(X), 0.5 * capsule.length, of_a);
}

void add(Difference& d, const Cylinder& cylinder, const Isometry3d& X, bool of_a) {
  d.add_segment(axis_of(X), 0.5 * cylinder.length, of_a);
  d.add_disk(axis_of(X), cylinder.radius, of_a);
}

void add(Difference& d, const Box& box, const Isometry3d& X, bool of_a) {
  for (int i = 0; i < 3; ++i) d.add_segment(X.linear().col(i), 0.5 * box.size[i], of_a);
}

template <class A, class B>
Difference difference(const A& a, const Isometry3d& X_WA, const B& b, const Isometry3d& X_WB) {
  Difference d;
  d.c = X_WA.translation() - X_WB.translation();
  add(d, a, X_WA, true);
  add(d, b, X_WB, false);
  return d;
}

/// Answer from witness points of the unrounded bodies.
Separation rounded(double distance, const Vector3d& p_WA, const Vector3d& p_WB, const Vector3d& normal_W,
                   double radius_a, double radius_b) {
  return {distance - radius_a - radius_b, p_WA - radius_a * normal_W, p_WB + radius_b * normal_W, normal_W};
}

template <class A, class B>
Separation by_difference(const A& a, const Isometry3d& X_WA, const B& b, const Isometry3d& X_WB,
                         const Vector3d& guess) {
  const DifferenceResult r = detail::signed_difference(difference(a, X_WA, b, X_WB), guess);
  return rounded(r.distance, X_WA.translation() + r.on_a, X_WB.translation() + r.on_b, r.normal, rounding(a),
                 rounding(b));
}

// ---- sphere against everything convex: a point in the frame of the other ----

detail::PointResult point_result(const Vector3d& p, const Sphere&) {
  const double distance = p.norm();
  return {distance, Vector3d::Zero(), distance > 0.0 ? Vector3d(p / distance) : Vector3d(Vector3d::UnitZ())};
}

detail::PointResult point_result(const Vector3d& p, const Capsule& capsule) {
  const Vector3d nearest(0, 0, detail::nearest_on_segment(p, Vector3d::UnitZ(), 0.5 * capsule.length));
  const double distance = (p - nearest).norm();
  return {distance, nearest, distance > 0.0 ? Vector3d((p - nearest) / distance) : Vector3d(Vector3d::UnitX())};
}

detail::PointResult point_result(const Vector3d& p, const Cylinder& cylinder) {
  return detail::point_cylinder(p, cylinder.radius, 0.5 * cylinder.length);
}

detail::PointResult point_result(const Vector3d& p, const Box& box) { return detail::point_box(p, 0.5 * box.size); }

template <class B>
requires(!std::is_same_v<B, Mesh>) Separation
    separation_of(const Sphere& a, const Isometry3d& X_WA, const B& b, const Isometry3d& X_WB) {
  const detail::PointResult r = point_result(seen_from(X_WB, X_WA.translation()), b);
  return rounded(r.distance, X_WA.translation(), X_WB * r.nearest, X_WB.linear() * r.normal, a.radius, rounding(b));
}

double distance_of(const Sphere& a, const Isometry3d& X_WA, const Sphere& b, const Isometry3d& X_WB) {
  return (X_WA.translation() - X_WB.translation()).norm() - a.radius - b.radius;
}

double distance_of(const Sphere& a, const Isometry3d& X_WA, const Capsule& b, const Isometry3d& X_WB) {
  const Vector3d p = X_WA.translation() - X_WB.translation();
  const Vector3d axis = axis_of(X_WB);
  return (p - detail::nearest_on_segment(p, axis, 0.5 * b.length) * axis).norm() - a.radius - b.radius;
}

double distance_of(const Sphere& a, const Isometry3d& X_WA, const Cylinder& b, const Isometry3d& X_WB) {
  const Vector3d p = X_WA.translation() - X_WB.translation();
  const Vector3d axis = axis_of(X_WB);
  const double z = p.dot(axis);
  return detail::half_plane_distance((p - z * axis).norm(), z, b.radius, 0.5 * b.length) - a.radius;
}

double distance_of(const Sphere& a, const Isometry3d& X_WA, const Box& b, const Isometry3d& X_WB) {
  return detail::point_box_distance(seen_from(X_WB, X_WA.translation()), 0.5 * b.size) - a.radius;
}

// ---- segments against segments and boxes ----

Separation separation_of(const Capsule& a, const Isometry3d& X_WA, const Capsule& b, const Isometry3d& X_WB) {
  const Vector3d u = axis_of(X_WA);
  const Vector3d v = axis_of(X_WB);
  const Vector3d c = X_WA.translation() - X_WB.translation();
  const detail::SegmentPair pair = detail::segment_segment(c, u, 0.5 * a.length, v, 0.5 * b.length);
  const Vector3d gap = c + pair.s * u - pair.t * v;
  const double distance = gap.norm();
  const Vector3d across = u.cross(v);
  Vector3d normal;
  if (distance > 1e-9 * (a.length + b.length)) {
    normal = gap / distance;
  } else if (across.squaredNorm() > detail::kParallel) {
    normal = (across.dot(gap) < 0.0 ? -1.0 : 1.0) * across.normalized();
  } else {
    normal = distance > 0.0 ? Vector3d(gap / distance) : Vector3d(X_WA.linear().col(0));
  }
  return rounded(distance, X_WA.translation() + pair.s * u, X_WB.translation() + pair.t * v, normal, a.radius,
                 b.radius);
}

double distance_of(const Capsule& a, const Isometry3d& X_WA, const Capsule& b, const Isometry3d& X_WB) {
  const Vector3d c = X_WA.translation() - X_WB.translation();
  return std::sqrt(detail::segment_segment(c, axis_of(X_WA), 0.5 * a.length, axis_of(X_WB), 0.5 * b.length).squared) -
         a.radius - b.radius;
}

/// A segment (axis of a capsule or cylinder) against a box, in the frame of the box.
struct AxisBox {
  Vector3d p;  ///< centre of the segment
  Vector3d d;  ///< its unit direction
  Vector3d h;  ///< half edges of the box
  detail::SegmentBox nearest;

  [[nodiscard]] Vector3d on_axis() const { return p + nearest.s * d; }
  [[nodiscard]] Vector3d on_box() const { return on_axis().cwiseMin(h).cwiseMax(-h); }
};

AxisBox axis_box(const Isometry3d& X_WA, double half, const Box& b, const Isometry3d& X_WB) {
  AxisBox r;
  r.p = seen_from(X_WB, X_WA.translation());
  r.d = X_WB.linear().transpose() * axis_of(X_WA);
  r.h = 0.5 * b.size;
  r.nearest = detail::segment_box(r.p, r.d, half, r.h);
  return r;
}

Separation separation_of(const Capsule& a, const Isometry3d& X_WA, const Box& b, const Isometry3d& X_WB) {
  const AxisBox r = axis_box(X_WA, 0.5 * a.length, b, X_WB);
  const Vector3d gap = r.on_axis() - r.on_box();
  const double distance = gap.norm();
  if (distance <= 1e-9 * (a.length + b.size.sum())) {
    return by_difference(a, X_WA, b, X_WB, X_WA.translation() - X_WB.translation());
  }
  return rounded(distance, X_WB * r.on_axis(), X_WB * r.on_box(), X_WB.linear() * gap / distance, a.radius, 0.0);
}

double distance_of(const Capsule& a, const Isometry3d& X_WA, const Box& b, const Isometry3d& X_WB) {
  const AxisBox r = axis_box(X_WA, 0.5 * a.length, b, X_WB);
  const double distance = std::sqrt(r.nearest.squared);
  if (distance > 1e-9 * (a.length + b.size.sum())) return distance - a.radius;
  return separation_of(a, X_WA, b, X_WB).distance;
}

bool overlap_of(const Capsule& a, const Isometry3d& X_WA, const Box& b, const Isometry3d& X_WB) {
  const double squared = axis_box(X_WA, 0.5 * a.length, b, X_WB).nearest.squared;
  if (squared > a.radius * a.radius) return false;
  if (squared < a.radius * a.radius) return true;
  return distance_of(a, X_WA, b, X_WB) < 0.0;
}

// ---- cylinder against capsule, cylinder and box ----
//
// Where the connection of the axes is at right angles to every cylinder's axis, it runs through the sides and the
// answer is that of capsules. Otherwise an end takes part: the general method, started from that connection.

/// Axes of two capsules or cylinders.
template <class A, class B>
struct AxisPair {
  Vector3d u, v, c;
  detail::SegmentPair nearest;

  AxisPair(const A& a, const Isometry3d& X_WA, const B& b, const Isometry3d& X_WB)
      : u(axis_of(X_WA)),
        v(axis_of(X_WB)),
        c(X_WA.translation() - X_WB.translation()),
        nearest(detail::segment_segment(c, u, 0.5 * a.length, v, 0.5 * b.length)) {}

  [[nodiscard]] Vector3d gap() const { return c + nearest.s * u - nearest.t * v; }

  /// Whether `gap`, of this `length`, leaves both bodies through their sides.
  [[nodiscard]] bool through_sides(const Vector3d& gap, double length) const {
    return (std::is_same_v<A, Capsule> || std::abs(gap.dot(u)) <= kRightAngle * length) &&
           (std::is_same_v<B, Capsule> || std::abs(gap.dot(v)) <= kRightAngle * length);
  }
};

template <class A>
Separation separation_of_axes(const A& a, const Isometry3d& X_WA, const Cylinder& b, const Isometry3d& X_WB) {
  const AxisPair<A, Cylinder> axes(a, X_WA, b, X_WB);
  const Vector3d gap = axes.gap();
  const double distance = gap.norm();
  const double core = std::is_same_v<A, Capsule> ? 0.0 : a.radius;
  if (distance > core + b.radius && axes.through_sides(gap, distance)) {
    return rounded(distance, X_WA.translation() + axes.nearest.s * axes.u, X_WB.translation() + axes.nearest.t * axes.v,
                   gap / distance, a.radius, b.radius);
  }
  return by_difference(a, X_WA, b, X_WB, distance > 0.0 ? gap : axes.c);
}

Separation separation_of(const Capsule& a, const Isometry3d& X_WA, const Cylinder& b, const Isometry3d& X_WB) {
  return separation_of_axes(a, X_WA, b, X_WB);
}

Separation separation_of(const Cylinder& a, const Isometry3d& X_WA, const Cylinder& b, const Isometry3d& X_WB) {
  return separation_of_axes(a, X_WA, b, X_WB);
}

template <class A>
double distance_of_axes(const A& a, const Isometry3d& X_WA, const Cylinder& b, const Isometry3d& X_WB) {
  const AxisPair<A, Cylinder> axes(a, X_WA, b, X_WB);
  const Vector3d gap = axes.gap();
  const double distance = gap.norm();
  const double core = std::is_same_v<A, Capsule> ? 0.0 : a.radius;
  if (distance > core + b.radius && axes.through_sides(gap, distance)) return distance - a.radius - b.radius;
  return by_difference(a, X_WA, b, X_WB, distance > 0.0 ? gap : axes.c).distance;
}

double distance_of(const Capsule& a, const Isometry3d& X_WA, const Cylinder& b, const Isometry3d& X_WB) {
  return distance_of_axes(a, X_WA, b, X_WB);
}

double distance_of(const Cylinder& a, const Isometry3d& X_WA, const Cylinder& b, const Isometry3d& X_WB) {
  return distance_of_axes(a, X_WA, b, X_WB);
}

/// Half length of the axis of the longest capsule inside: the cylinder's, shortened by the radius at both ends.
double inner_half(const Cylinder& cylinder) { return 0.5 * cylinder.length - cylinder.radius; }
double inner_half(const Capsule& capsule) { return 0.5 * capsule.length; }

/// The sandwich: free if the capsules around are apart, overlapping if those inside meet; open in between.
template <class A>
bool overlap_of_axes(const A& a, const Isometry3d& X_WA, const Cylinder& b, const Isometry3d& X_WB) {
  const double reach = a.radius + b.radius;
  const AxisPair<A, Cylinder> axes(a, X_WA, b, X_WB);
  if (axes.nearest.squared > reach * reach) return false;
  const double half_a = inner_half(a);
  const double half_b = inner_half(b);
  if (half_a >= 0.0 && half_b >= 0.0 && reach > 0.0) {
    const double inner = detail::segment_segment(axes.c, axes.u, half_a, axes.v, half_b).squared;
    if (inner < reach * reach) return true;
  }
  if constexpr (std::is_same_v<A, Cylinder>) {
    return detail::difference_overlaps(difference(a, X_WA, b, X_WB), axes.nearest.squared > 0.0 ? axes.gap() : axes.c);
  } else {
    return distance_of(a, X_WA, b, X_WB) < 0.0;
  }
}

bool overlap_of(const Capsule& a, const Isometry3d& X_WA, const Cylinder& b, const Isometry3d& X_WB) {
  return overlap_of_axes(a, X_WA, b, X_WB);
}

bool overlap_of(const Cylinder& a, const Isometry3d& X_WA, const Cylinder& b, const Isometry3d& X_WB) {
  return overlap_of_axes(a, X_WA, b, X_WB);
}

Separation separation_of(const Cylinder& a, const Isometry3d& X_WA, const Box& b, const Isometry3d& X_WB) {
  const AxisBox r = axis_box(X_WA, 0.5 * a.length, b, X_WB);
  const Vector3d gap = r.on_axis() - r.on_box();
  const double distance = gap.norm();
  if (distance > a.radius && std::abs(gap.dot(r.d)) <= kRightAngle * distance) {
    return rounded(distance, X_WB * r.on_axis(), X_WB * r.on_box(), X_WB.linear() * gap / distance, a.radius, 0.0);
  }
  return by_difference(a, X_WA, b, X_WB, X_WB.linear() * (distance > 0.0 ? gap : r.p));
}

double distance_of(const Cylinder& a, const Isometry3d& X_WA, const Box& b, const Isometry3d& X_WB) {
  const AxisBox r = axis_box(X_WA, 0.5 * a.length, b, X_WB);
  const Vector3d gap = r.on_axis() - r.on_box();
  const double distance = gap.norm();
  if (distance > a.radius && std::abs(gap.dot(r.d)) <= kRightAngle * distance) return distance - a.radius;
  return by_difference(a, X_WA, b, X_WB, X_WB.linear() * (distance > 0.0 ? gap : r.p)).distance;
}

bool overlap_of(const Cylinder& a, const Isometry3d& X_WA, const Box& b, const Isometry3d& X_WB) {
  const double half = 0.5 * a.length;
  const double squared_radius = a.radius * a.radius;
  const Vector3d p = seen_from(X_WB, X_WA.translation());
  const Vector3d h = 0.5 * b.size;
  if ((p.cwiseAbs() - h).cwiseMax(0.0).squaredNorm() > squared_radius + half * half) return false;
  const Vector3d d = X_WB.linear().transpose() * axis_of(X_WA);
  const detail::SegmentBox outer = detail::segment_box(p, d, half, h);
  if (outer.squared > squared_radius) return false;
  const Vector3d on_axis = p + outer.s * d;
  const Vector3d gap = on_axis - on_axis.cwiseMin(h).cwiseMax(-h);
  // The nearest point of the box lies strictly inside the cylinder: beside the axis point, no farther than the end.
  const double along = gap.dot(d);
  if (outer.squared < squared_radius && std::abs(outer.s - along) < half) return true;
  const double inner = inner_half(a);
  if (inner >= 0.0 && a.radius > 0.0 && detail::segment_box(p, d, inner, h).squared < squared_radius) return true;
  if (std::abs(d.dot(p)) > half + h.dot(d.cwiseAbs())) return false;  // beyond an end plane
  return detail::difference_overlaps(difference(a, X_WA, b, X_WB), X_WB.linear() * (outer.squared > 0.0 ? gap : p));
}

// ---- boxes ----

Separation separation_of(const Box& a, const Isometry3d& X_WA, const Box& b, const Isometry3d& X_WB) {
  return by_difference(a, X_WA, b, X_WB, X_WA.translation() - X_WB.translation());
}

double distance_of(const Box& a, const Isometry3d& X_WA, const Box& b, const Isometry3d& X_WB) {
  return separation_of(a, X_WA, b, X_WB).distance;
}

/// Separating axes: the fifteen directions of Gottschalk, Lin and Manocha, "OBBTree", 1996, DOI 10.1145/237170.237244,
/// in the frame of `b`, without normalising.
bool overlap_of(const Box& a, const Isometry3d& X_WA, const Box& b, const Isometry3d& X_WB) {
  const Eigen::Matrix3d R = X_WB.linear().transpose() * X_WA.linear();
  const Eigen::Matrix3d S = R.cwiseAbs();
  const Vector3d p = seen_from(X_WB, X_WA.translation());
  const Vector3d ha = 0.5 * a.size;
  const Vector3d hb = 0.5 * b.size;
  if (((p.cwiseAbs() - hb - S * ha).array() >= 0.0).any()) return false;
  if ((((R.transpose() * p).cwiseAbs() - ha - S.transpose() * hb).array() >= 0.0).any()) return false;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const int k = (i + 2) % 3;
    for (int m = 0; m < 3; ++m) {  // axis e_i x R_m of the two boxes
      const double sine_squared = R(j, m) * R(j, m) + R(k, m) * R(k, m);
      if (sine_squared <= detail::kParallel) continue;
      const int q = (m + 1) % 3;
      const int r = (m + 2) % 3;
      const double reach = hb[j] * S(k, m) + hb[k] * S(j, m) + ha[q] * S(i, r) + ha[r] * S(i, q);
      if (std::abs(p[k] * R(j, m) - p[j] * R(k, m)) >= reach) return false;
    }
  }
  return true;
}

// ---- meshes ----

template <class A>
Separation separation_of(const A& a, const Isometry3d& X_WA, const Mesh& b, const Isometry3d& X_WB) {
  return detail::mesh_separation(a, X_WA, b, X_WB);
}

template <class A>
bool overlap_of(const A& a, const Isometry3d& X_WA, const Mesh& b, const Isometry3d& X_WB) {
  return detail::mesh_overlaps(a, X_WA, b, X_WB);
}

template <class A, class B>
double distance_of(const A& a, const Isometry3d& X_WA, const B& b, const Isometry3d& X_WB) {
  return separation_of(a, X_WA, b, X_WB).distance;
}

template <class A, class B>
bool overlap_of(const A& a, const Isometry3d& X_WA, const B& b, const Isometry3d& X_WB) {
  return distance_of(a, X_WA, b, X_WB) < 0.0;
}

Separation mirrored(const Separation& s) { return {s.distance, s.p_WB, s.p_WA, -s.normal_W}; }

}  // namespace

Separation separation(const Shape& a, const Isometry3d& X_WA, const Shape& b, const Isometry3d& X_WB) {
  return std::visit(
      [&]<class A, class B>(const A& one, const B& other) {
        if constexpr (kRank<A> <= kRank<B>) {
          return separation_of(one, X_WA, other, X_WB);
        } else {
          return mirrored(separation_of(other, X_WB, one, X_WA));
        }
      },
      a, b);
}

double signed_distance(const Shape& a, const Isometry3d& X_WA, const Shape& b, const Isometry3d& X_WB) {
  return std::visit(
      [&]<class A, class B>(const A& one, const B& other) {
        if constexpr (kRank<A> <= kRank<B>) {
          return distance_of(one, X_WA, other, X_WB);
        } else {
          return distance_of(other, X_WB, one, X_WA);
        }
      },
      a, b);
}

bool overlaps(const Shape& a, const Isometry3d& X_WA, const Shape& b, const Isometry3d& X_WB) {
  return std::visit(
      [&]<class A, class B>(const A& one, const B& other) {
        if constexpr (kRank<A> <= kRank<B>) {
          return overlap_of(one, X_WA, other, X_WB);
        } else {
          return overlap_of(other, X_WB, one, X_WA);
        }
      },
      a, b);
}

}  // namespace modsearch
