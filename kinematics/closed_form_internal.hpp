#pragma once

// Distances between points, segments, boxes and cylinders that can be written down. Everything is in the frame of the
// second body, which is centred at the origin; nothing here allocates or checks.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace modsearch::detail {

/// Signed distance of a point from a solid, the nearest point of its surface and the outward unit normal there.
struct PointResult {
  double distance = 0.0;                              ///< [m], negative inside
  Eigen::Vector3d nearest = Eigen::Vector3d::Zero();  ///< on the surface
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< gradient of the distance in the point
};

/// -1 for negative numbers, +1 for all others, so that a point on a plane of symmetry has one fixed side.
[[nodiscard]] inline double side(double x) { return x < 0.0 ? -1.0 : 1.0; }

/// Signed distance of the point `p` from the box with half edges `h` about the origin [m].
[[nodiscard]] inline double point_box_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& h) {
  const double x = std::abs(p.x()) - h.x();
  const double y = std::abs(p.y()) - h.y();
  const double z = std::abs(p.z()) - h.z();
  const double inside = std::max({x, y, z});
  if (inside <= 0.0) return inside;
  const double ox = std::max(x, 0.0);
  const double oy = std::max(y, 0.0);
  const double oz = std::max(z, 0.0);
  return std::sqrt(ox * ox + oy * oy + oz * oz);
}

/// The same with nearest point and normal. Inside, the nearest face wins; of equals the one with the lowest axis.
[[nodiscard]] inline PointResult point_box(const Eigen::Vector3d& p, const Eigen::Vector3d& h) {
  PointResult result;
  const Eigen::Vector3d nearest = p.cwiseMin(h).cwiseMax(-h);
  const double distance = (p - nearest).norm();
  if (distance > 0.0) return {distance, nearest, (p - nearest) / distance};
  int axis = 0;
  (p.cwiseAbs() - h).maxCoeff(&axis);
  result.distance = std::abs(p[axis]) - h[axis];
  result.normal = Eigen::Vector3d::Zero();
  result.normal[axis] = side(p[axis]);
  result.nearest = p;
  result.nearest[axis] = side(p[axis]) * h[axis];
  return result;
}

/// Signed distance in the half plane (rho, z) from a cylinder of `radius` and half length `half` [m].
[[nodiscard]] inline double half_plane_distance(double rho, double z, double radius, double half) {
  const double radial = rho - radius;
  const double axial = std::abs(z) - half;
  if (radial <= 0.0 || axial <= 0.0) return std::max(radial, axial);
  return std::sqrt(radial * radial + axial * axial);
}

/// Signed distance of the point `p` from the cylinder about the z axis, with nearest point and normal.
[[nodiscard]] inline PointResult point_cylinder(const Eigen::Vector3d& p, double radius, double half) {
  const double rho = std::sqrt(p.x() * p.x() + p.y() * p.y());
  const Eigen::Vector3d out =
      rho > 0.0 ? Eigen::Vector3d(p.x() / rho, p.y() / rho, 0.0) : Eigen::Vector3d(Eigen::Vector3d::UnitX());
  const double up = side(p.z());
  const double radial = rho - radius;
  const double axial = std::abs(p.z()) - half;
  const double distance = std::sqrt(radial * radial + axial * axial);
  if (radial > 0.0 && axial > 0.0 && distance > 0.0) {
    return {distance, radius * out + Eigen::Vector3d(0, 0, up * half),
            (radial * out + Eigen::Vector3d(0, 0, up * axial)) / distance};
  }
  if (radial > axial) return {radial, radius * out + Eigen::Vector3d(0, 0, p.z()), out};
  return {axial, Eigen::Vector3d(p.x(), p.y(), up * half), Eigen::Vector3d(0, 0, up)};
}

/// Parameter in [-half, half] of the point of the segment `t * direction` nearest to `p`.
[[nodiscard]] inline double nearest_on_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& direction,
                                               double half) {
  return std::clamp(direction.dot(p), -half, half);
}

/// Squared sine below which two directions count as parallel: over 1 m, such lines drift apart by 0.1 um.
inline constexpr double kParallel = 1e-14;

/// Nearest points `s * u` + `c` and `t * v` of two segments.
struct SegmentPair {
  double s = 0.0;
  double t = 0.0;
  double squared = 0.0;   ///< squared distance [m^2]
  bool crossing = false;  ///< both points are inner points, so the shortest connection is at right angles to both
};

/// Nearest points of the segment c + s * u, |s| <= a, and the segment t * v, |t| <= b; `u`, `v` are unit vectors.
///
/// Four candidates pin an end of one segment, the fifth is the common perpendicular. Taking the best of all five needs
/// no threshold for parallel lines: where the perpendicular is badly conditioned an end is as good.
[[nodiscard]] inline SegmentPair segment_segment(const Eigen::Vector3d& c, const Eigen::Vector3d& u, double a,
                                                 const Eigen::Vector3d& v, double b) {
  const double uv = u.dot(v);
  const double uc = u.dot(c);
  const double vc = v.dot(c);
  const auto squared = [&](double s, double t) { return (c + s * u - t * v).squaredNorm(); };
  const Eigen::Vector3d across = u.cross(v);
  const double determinant = across.squaredNorm();
  if (determinant > kParallel) {
    // By cross products: 1 - uv^2 would lose all its digits for lines that are nearly parallel.
    const double s = -c.cross(v).dot(across) / determinant;
    const double t = vc + s * uv;
    if (std::abs(s) <= a && std::abs(t) <= b) return {s, t, squared(s, t), true};
  }
  // Comparing the expanded square is cheap and accurate enough to choose; the winner is measured afresh.
  SegmentPair best;
  double best_value = 0.0;
  bool first = true;
  const auto offer = [&](double s, double t) {
    const double value = s * (s - 2.0 * t * uv + 2.0 * uc) + t * (t - 2.0 * vc);
    if (first || value < best_value) {
      best.s = s;
      best.t = t;
      best_value = value;
      first = false;
    }
  };
  for (const double s : {-a, a}) offer(s, std::clamp(vc + s * uv, -b, b));
  for (const double t : {-b, b}) offer(std::clamp(t * uv - uc, -a, a), t);
  best.squared = squared(best.s, best.t);
  if (determinant <= kParallel && best.squared > 0.0) {
    // Nearly parallel: overlapping stretches are equally near everywhere, so alternate once from the middle of the
    // overlap as well, which keeps the witness away from the ends.
    const double low = std::max(-a, std::min((-b - vc) * side(uv), (b - vc) * side(uv)));
    const double high = std::min(a, std::max((-b - vc) * side(uv), (b - vc) * side(uv)));
    if (low < high) {
      const double s = 0.5 * (low + high);
      const double t = std::clamp(vc + s * uv, -b, b);
      const double value = squared(s, t);
      if (value <= best.squared + 1e-15 * c.squaredNorm()) best = {s, t, std::min(value, best.squared), false};
    }
  }
  return best;
}

/// Nearest points of a segment and a box about the origin.
struct SegmentBox {
  double s = 0.0;        ///< parameter on the segment
  double squared = 0.0;  ///< squared distance [m^2]; 0 when they meet
  bool interior = true;  ///< the nearest point is no end of the segment: the connection is at right angles to it
};

/// Nearest point of the segment p + s * d, |s| <= `half`, to the box with half edges `h`; `d` is a unit vector.
///
/// Half the derivative of the squared distance is sum_i d_i * excess_i(s), a nondecreasing broken line with at most six
/// corners: cut the bracket at each corner, then the rest is one straight piece.
[[nodiscard]] inline SegmentBox segment_box(const Eigen::Vector3d& p, const Eigen::Vector3d& d, double half,
                                            const Eigen::Vector3d& h) {
  const auto excess = [&](int i, double s) {
    const double x = p[i] + s * d[i];
    return x - std::min(std::max(x, -h[i]), h[i]);
  };
  const auto slope = [&](double s) { return d[0] * excess(0, s) + d[1] * excess(1, s) + d[2] * excess(2, s); };
  const auto at = [&](double s, bool interior) {
    const double x = excess(0, s);
    const double y = excess(1, s);
    const double z = excess(2, s);
    return SegmentBox{s, x * x + y * y + z * z, interior};
  };
  double low = -half;
  double high = half;
  double slope_low = slope(low);
  if (slope_low >= 0.0) return at(low, slope_low == 0.0);
  double slope_high = slope(high);
  if (slope_high <= 0.0) return at(high, slope_high == 0.0);
  for (int i = 0; i < 3; ++i) {
    if (std::abs(d[i]) < 1e-14) continue;
    const double inverse = 1.0 / d[i];
    for (const double bound : {-h[i], h[i]}) {
      const double s = (bound - p[i]) * inverse;
      if (s <= low || s >= high) continue;
      const double value = slope(s);
      if (value == 0.0) return at(s, true);
      if (value < 0.0) {
        low = s;
        slope_low = value;
      } else {
        high = s;
        slope_high = value;
      }
    }
  }
  return at(low - slope_low * (high - low) / (slope_high - slope_low), true);
}

}  // namespace modsearch::detail
