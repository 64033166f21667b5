#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/bounding_capsule.hpp>

namespace modsearch {
namespace {

// The capsule in the shape's own frame: a segment along one of its axes.
struct LocalCapsule {
  int axis;
  double half_length;
  double radius;
};

LocalCapsule local(const Sphere& sphere, double) { return {2, 0.0, sphere.radius}; }
LocalCapsule local(const Cylinder& cylinder, double) { return {2, 0.5 * cylinder.length, cylinder.radius}; }
LocalCapsule local(const Capsule& capsule, double) { return {2, 0.5 * capsule.length, capsule.radius}; }
LocalCapsule local(const Mesh&, double bounding_radius) { return {2, 0.0, bounding_radius}; }

LocalCapsule local(const Box& box, double) {
  int longest = 0;
  box.size.maxCoeff(&longest);
  const double width = box.size[(longest + 1) % 3];
  const double depth = box.size[(longest + 2) % 3];
  return {longest, 0.5 * box.size[longest], 0.5 * std::sqrt(width * width + depth * depth)};
}

// Squared distance of two segments, centre +- half axis. With both parameters free the minimum solves a 2 x 2 system;
// where it leaves the segments, clamping one parameter and minimising over the other, in turn, finds it (the objective
// is convex, and only one clamped parameter can be wrong).
double squared_distance(const BoundingCapsule& a, const BoundingCapsule& b) {
  const Eigen::Vector3d between = a.centre_W - b.centre_W;
  const double aa = a.half_length * a.half_length;
  const double bb = b.half_length * b.half_length;
  const double ab = a.half_axis_W.dot(b.half_axis_W);
  const double ta = a.half_axis_W.dot(between);
  const double tb = b.half_axis_W.dot(between);
  const double determinant = aa * bb - ab * ab;
  double s = determinant > 0.0 ? std::clamp((ab * tb - bb * ta) / determinant, -1.0, 1.0) : 0.0;
  const double t = bb > 0.0 ? std::clamp((tb + s * ab) / bb, -1.0, 1.0) : 0.0;
  s = aa > 0.0 ? std::clamp((t * ab - ta) / aa, -1.0, 1.0) : 0.0;
  return (between + s * a.half_axis_W - t * b.half_axis_W).squaredNorm();
}

constexpr double kRounding = 1e-9;

}  // namespace

BoundingCapsule bounding_capsule(const Shape& shape, double bounding_radius, const Eigen::Isometry3d& X_WG) {
  const LocalCapsule capsule = std::visit([&](const auto& one) { return local(one, bounding_radius); }, shape);
  return {X_WG.translation(), capsule.half_length * X_WG.linear().col(capsule.axis), capsule.half_length,
          capsule.radius};
}

double gap(const BoundingCapsule& a, const BoundingCapsule& b) {
  return std::sqrt(squared_distance(a, b)) - a.radius - b.radius - kRounding;
}

bool apart(const BoundingCapsule& a, const BoundingCapsule& b, double distance) {
  if (balls_apart(a, b, distance)) return true;
  const double reach = a.radius + b.radius + distance + kRounding;
  return reach < 0.0 || squared_distance(a, b) > reach * reach;
}

}  // namespace modsearch
