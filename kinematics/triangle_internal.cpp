#include "triangle_internal.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <variant>

#include "closed_form_internal.hpp"
#include "gjk_internal.hpp"
#include "minkowski_internal.hpp"

namespace modsearch::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Adds the shape without its rounding to `d` and returns the rounding radius [m].
double add_core(Difference&, const Sphere& sphere, const Isometry3d&) { return sphere.radius; }

double add_core(Difference& d, const Capsule& capsule, const Isometry3d& X) {
  d.add_segment(X.linear().col(2), 0.5 * capsule.length, true);
  return capsule.radius;
}

double add_core(Difference& d, const Cylinder& cylinder, const Isometry3d& X) {
  d.add_segment(X.linear().col(2), 0.5 * cylinder.length, true);
  d.add_disk(X.linear().col(2), cylinder.radius, true);
  return 0.0;
}

double add_core(Difference& d, const Box& box, const Isometry3d& X) {
  for (int i = 0; i < 3; ++i) d.add_segment(X.linear().col(i), 0.5 * box.size[i], true);
  return 0.0;
}

/// Best of the directions that can part a body and triangles, each tried both ways.
Vector3d least_parting(const Difference& d) {
  double best = -std::numeric_limits<double>::infinity();
  Vector3d normal = Vector3d::UnitZ();
  const auto offer = [&](const Vector3d& direction) {
    const double squared = direction.squaredNorm();
    if (!(squared > kParallel * kParallel)) return;
    for (const double sign : {1.0, -1.0}) {
      const Vector3d n = sign / std::sqrt(squared) * direction;
      const double value = separation_along(d, n);
      if (value > best) {
        best = value;
        normal = n;
      }
    }
  };
  const auto edge = [&](int t, int k) -> Vector3d { return d.corners[t][(k + 1) % 3] - d.corners[t][k]; };
  for (int t = 0; t < d.n_triangles; ++t) {
    offer(edge(t, 0).cross(edge(t, 1)));
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < d.n_segments; ++i) offer(edge(t, k).cross(d.direction[i]));
      for (int other = t + 1; other < d.n_triangles; ++other) {
        for (int m = 0; m < 3; ++m) offer(edge(t, k).cross(edge(other, m)));
      }
    }
  }
  for (int j = 0; j < d.n_disks; ++j) offer(d.axis[j]);
  for (int i = 0; i < d.n_segments; ++i) {
    for (int k = i + 1; k < d.n_segments; ++k) offer(d.direction[i].cross(d.direction[k]));
  }
  return normal;
}

/// Separation of the sharp bodies of `d`, unless they overlap.
std::optional<Separation> gap(const Difference& d, const Vector3d& p_WA, const Vector3d& p_WB) {
  Descent descent(d, d.c);
  Descent::State state = Descent::State::kGoing;
  while (state == Descent::State::kGoing) state = descent.step();
  if (state == Descent::State::kOverlap || descent.lower() <= 0.0) return std::nullopt;
  Separation s{descent.upper(), p_WA, p_WB, descent.normal()};
  add_witnesses(d, descent.simplex(), s.p_WA, s.p_WB);
  return s;
}

/// Point of the interval [0, 1] where the convex function `f` is least, by golden sections.
template <class F>
double least_at(const F& f) {
  constexpr double kGolden = 0.6180339887498949;
  double low = 0.0;
  double high = 1.0;
  double left = high - kGolden * (high - low);
  double right = low + kGolden * (high - low);
  double f_left = f(left);
  double f_right = f(right);
  for (int step = 0; step < 42; ++step) {  // 0.618^42 < 2e-9
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

double depth_of_point(const Vector3d& p, const Box& box) { return point_box_distance(p, 0.5 * box.size); }
double depth_of_point(const Vector3d& p, const Cylinder& cylinder) {
  return half_plane_distance(std::hypot(p.x(), p.y()), p.z(), cylinder.radius, 0.5 * cylinder.length);
}
PointResult nearest_surface(const Vector3d& p, const Box& box) { return point_box(p, 0.5 * box.size); }
PointResult nearest_surface(const Vector3d& p, const Cylinder& cylinder) {
  return point_cylinder(p, cylinder.radius, 0.5 * cylinder.length);
}

/// Deepest point of an overlapping triangle: the signed distance is convex, so one golden search inside another.
template <class Solid>
Separation deepest(const Solid& a, const Isometry3d& X_WA, const Triangle& b) {
  const Isometry3d X_AW = X_WA.inverse();
  const Vector3d corner = X_AW * b[0];
  const Vector3d along = X_AW.linear() * (b[1] - b[0]);
  const Vector3d up = X_AW.linear() * (b[2] - b[0]);
  const auto point = [&](double u, double v) -> Vector3d { return corner + u * (1.0 - v) * along + v * up; };
  const auto row = [&](double v) { return least_at([&](double u) { return depth_of_point(point(u, v), a); }); };
  const double v = least_at([&](double w) { return depth_of_point(point(row(w), w), a); });
  Vector3d best = point(row(v), v);
  for (const Vector3d& candidate : {corner, Vector3d(corner + along), Vector3d(corner + up)}) {
    if (depth_of_point(candidate, a) < depth_of_point(best, a)) best = candidate;
  }
  const PointResult r = nearest_surface(best, a);
  return {r.distance, X_WA * r.nearest, X_WA * best, -(X_WA.linear() * r.normal)};
}

/// Where the axis or centre of a rounded shape meets the triangle: the distance of the sharp bodies is zero there.
Separation meeting(const Difference& d, const Vector3d& p_WA, const Vector3d& p_WB) {
  const Vector3d normal = least_parting(d);
  Vector3d at = p_WA;
  if (d.n_segments > 0) {
    // The axis crosses the plane of the triangle there, or lies in it and any common point will do.
    const auto& [p, q, r] = d.corners[0];
    const Vector3d plane = (q - p).cross(r - p);
    const double slope = plane.dot(d.direction[0]);
    const double height = plane.dot(p_WB + p - p_WA);
    const double t = std::abs(slope) > 1e-12 * plane.norm() ? height / slope : 0.0;
    at += std::clamp(t, -d.half[0], d.half[0]) * d.direction[0];
  }
  return {0.0, at, at, normal};
}

/// Corner of the first triangle, which belongs to A, that is lowest along `n`, relative to its centre.
Vector3d lowest_corner(const Difference& d, const Vector3d& n) {
  const auto& corners = d.corners[0];
  return *std::min_element(corners.begin(), corners.end(),
                           [&](const Vector3d& one, const Vector3d& other) { return n.dot(one) < n.dot(other); });
}

Triangle relative(const Triangle& triangle, const Vector3d& centre) {
  return {triangle[0] - centre, triangle[1] - centre, triangle[2] - centre};
}

Vector3d centre_of(const Triangle& triangle) { return (triangle[0] + triangle[1] + triangle[2]) / 3.0; }

}  // namespace

Separation triangle_separation(const Shape& a, const Isometry3d& X_WA, const Triangle& b) {
  const Vector3d centre = centre_of(b);
  return std::visit(
      [&]<class S>(const S& shape) -> Separation {
        if constexpr (std::is_same_v<S, Mesh>) {
          throw std::logic_error("triangle_separation: a mesh is measured triangle by triangle");
        } else {
          Difference d;
          d.c = X_WA.translation() - centre;
          const double radius = add_core(d, shape, X_WA);
          d.add_triangle(relative(b, centre), false);
          std::optional<Separation> s = gap(d, X_WA.translation(), centre);
          if constexpr (std::is_same_v<S, Box> || std::is_same_v<S, Cylinder>) {
            return s ? *s : deepest(shape, X_WA, b);
          } else {
            if (!s) s = meeting(d, X_WA.translation(), centre);
            s->distance -= radius;
            s->p_WA -= radius * s->normal_W;
            return *s;
          }
        }
      },
      a);
}

Separation triangle_separation(const Triangle& a, const Triangle& b) {
  const Vector3d centre_a = centre_of(a);
  const Vector3d centre_b = centre_of(b);
  Difference d;
  d.c = centre_a - centre_b;
  d.add_triangle(relative(a, centre_a), true);
  d.add_triangle(relative(b, centre_b), false);
  if (const std::optional<Separation> s = gap(d, centre_a, centre_b)) return *s;
  Separation s;
  s.normal_W = least_parting(d);
  s.distance = separation_along(d, s.normal_W);
  // The corner of A that reaches deepest; B's witness is where it has to go.
  s.p_WA = centre_a + lowest_corner(d, s.normal_W);
  s.p_WB = s.p_WA - s.distance * s.normal_W;
  return s;
}

}  // namespace modsearch::detail
