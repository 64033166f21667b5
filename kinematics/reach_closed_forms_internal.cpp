#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/kinematics/reach_closed_forms_internal.hpp>
#include <numbers>

namespace modsearch::internal {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
// Structure counts as exact below this, relative to the arm's size: it then costs less than this of the distance.
constexpr double kRounding = 1e-13;
// Closer than this to a point or axis about which everything turns alike, minima are not (numerically) isolated.
constexpr double kDegenerate = 1e-7;

double into_turn(const ReachLink& link, double q) {
  if (q >= link.lower && q <= link.upper) return q;
  return std::min(q - kTurn * std::floor((q - link.lower) / kTurn), link.upper);
}

// A point that turns about an axis: c + cos(q) a + sin(q) b.
struct Circle {
  Eigen::Vector3d c, a, b;
  [[nodiscard]] Eigen::Vector3d at(double q) const { return c + std::cos(q) * a + std::sin(q) * b; }
};

// The circle of `point` of the frame that moves with a joint; R, p lead to the joint's frame.
Circle circle_of(const Eigen::Matrix3d& R, const Eigen::Vector3d& p, const Eigen::Vector3d& point) {
  return {p + R.col(2) * point.z(), R.col(0) * point.x() + R.col(1) * point.y(),
          R.col(1) * point.x() - R.col(0) * point.y()};
}

// The angles q (one or two) at which offset + A cos(q) + B sin(q) comes closest to `value`.
struct Angles {
  std::array<double, 2> q{};
  int count = 0;
};
Angles angles_of(double A, double B, double value_less_offset) {
  const double amplitude = std::hypot(A, B);
  const double middle = std::atan2(B, A);
  const double ratio = amplitude > 0.0 ? std::clamp(value_less_offset / amplitude, -1.0, 1.0) : 1.0;
  if (ratio >= 1.0) return {{middle, 0.0}, 1};
  if (ratio <= -1.0) return {{middle + 0.5 * kTurn, 0.0}, 1};
  const double half = std::acos(ratio);
  return {{middle + half, middle - half}, 2};
}

// Where the axis through p along the unit vector `a` meets the z axis: its height; nothing if they are parallel or
// skew.
std::optional<double> meeting_height(const Eigen::Vector3d& p, const Eigen::Vector3d& a) {
  const double across = std::hypot(a.x(), a.y());
  if (across < 1e-3) return std::nullopt;  // nearly parallel: the meeting point would be ill-defined
  const double skew = (p.x() * a.y() - p.y() * a.x()) / across;
  if (std::abs(skew) > kRounding * (1.0 + p.norm())) return std::nullopt;
  const double along = -(p.x() * a.x() + p.y() * a.y()) / (across * across);
  return p.z() + along * a.z();
}

// Collects postures whose joints from 1 on are known: joint 0 turns the tip towards the target.
class Collector {
 public:
  Collector(const ReachProblem& problem, double tie) : problem_{problem}, tie_{tie} {
    rho_t_ = std::hypot(problem.target.x(), problem.target.y());
    // Every turn of joint 0 is as good as any other when the target is on its axis.
    result_.complete = rho_t_ > kDegenerate;
  }

  void add(const Eigen::Vector3d& tip, double q1, double q2 = 0.0) {
    const Eigen::Vector3d& t = problem_.target;
    const double rho = std::hypot(tip.x(), tip.y());
    const double distance = std::hypot(rho - rho_t_, tip.z() - t.z());
    if (rho <= kDegenerate) result_.complete = false;
    if (distance > least_ + tie_) return;
    const double q0 = std::atan2(t.y() * tip.x() - t.x() * tip.y(), t.x() * tip.x() + t.y() * tip.y());
    const auto& links = problem_.links;
    const ReachJoints q{into_turn(links[0], q0), into_turn(links[1], q1),
                        problem_.n == 3 ? into_turn(links[2], q2) : 0.0};
    if (distance < least_ - tie_) result_.minima.resize(0);
    if (distance < least_) {
      least_ = distance;
      result_.minima.add_first({q, distance});
    } else {
      result_.minima.add({q, distance});
    }
  }

  void not_isolated() { result_.complete = false; }
  void family_along(int joint) { result_.family_joint = joint; }
  [[nodiscard]] double rho_t() const { return rho_t_; }
  [[nodiscard]] const ClosedForm& result() const { return result_; }

 private:
  const ReachProblem& problem_;
  double tie_;
  ClosedForm result_;
  double rho_t_ = 0.0;
  double least_ = std::numeric_limits<double>::infinity();
};

// The circle lies on a sphere about the point of the z axis at `height`; as seen in (rho, z) it is an arc about that
// point, and the nearest point of an arc is where the ray to the target meets it, or the end of the arc.
void nearest_on_spherical_arc(const Circle& circle, double height, const Eigen::Vector3d& t, Collector& collect,
                              double q2 = 0.0) {
  const double radius = (circle.at(0.0) - height * Eigen::Vector3d::UnitZ()).norm();
  const double away = std::hypot(collect.rho_t(), t.z() - height);
  if (away <= kDegenerate || radius <= kDegenerate) collect.not_isolated();
  const double z = away > 0.0 ? height + radius * (t.z() - height) / away : circle.c.z();
  const Angles angles = angles_of(circle.a.z(), circle.b.z(), z - circle.c.z());
  for (int i = 0; i < angles.count; ++i) {
    const double q1 = angles.q[static_cast<std::size_t>(i)];
    collect.add(circle.at(q1), q1, q2);
  }
}

// The circle's plane is horizontal: only rho varies.
void nearest_on_level_circle(const Circle& circle, Collector& collect) {
  // rho^2 = |c|^2 + |a|^2 + 2 (c . a cos q + c . b sin q), horizontally
  const double A = 2.0 * circle.c.head<2>().dot(circle.a.head<2>());
  const double B = 2.0 * circle.c.head<2>().dot(circle.b.head<2>());
  if (std::hypot(A, B) <= kDegenerate) collect.not_isolated();
  const double squares = circle.c.head<2>().squaredNorm() + circle.a.head<2>().squaredNorm();
  const Angles angles = angles_of(A, B, collect.rho_t() * collect.rho_t() - squares);
  for (int i = 0; i < angles.count; ++i) {
    const double q1 = angles.q[static_cast<std::size_t>(i)];
    collect.add(circle.at(q1), q1);
  }
}

// The circle's plane contains the z axis: in it the target appears on either side of the axis.
void nearest_on_meridional_circle(const Circle& circle, const Eigen::Vector3d& outward, const Eigen::Vector3d& t,
                                  Collector& collect) {
  for (const double side : {1.0, -1.0}) {
    const Eigen::Vector3d seen = side * collect.rho_t() * outward + t.z() * Eigen::Vector3d::UnitZ() - circle.c;
    if (seen.norm() <= kDegenerate) collect.not_isolated();
    const double q1 = std::atan2(seen.dot(circle.b), seen.dot(circle.a));
    collect.add(circle.at(q1), q1);
  }
}

std::optional<ClosedForm> of_two(const ReachProblem& problem, double tie) {
  const ReachLink& base = problem.links[0];
  const Eigen::Vector3d axis = base.R.col(2);
  const Circle circle = circle_of(base.R, base.p, problem.links[1].p);
  Collector collect{problem, tie};
  if (circle.a.norm() <= kDegenerate) return std::nullopt;  // the tip is on the second axis
  if (std::hypot(axis.x(), axis.y()) <= kRounding) {
    nearest_on_level_circle(circle, collect);
    return collect.result();
  }
  if (const std::optional<double> height = meeting_height(base.p, axis)) {
    nearest_on_spherical_arc(circle, *height, problem.target, collect);
    return collect.result();
  }
  if (std::abs(axis.z()) <= kRounding && std::abs(circle.c.dot(axis)) <= kRounding * (1.0 + circle.c.norm())) {
    nearest_on_meridional_circle(circle, axis.cross(Eigen::Vector3d::UnitZ()), problem.target, collect);
    return collect.result();
  }
  return std::nullopt;
}

std::optional<ClosedForm> of_three(const ReachProblem& problem, double tie) {
  const ReachLink& base = problem.links[0];
  const ReachLink& one = problem.links[1];
  const ReachLink& two = problem.links[2];
  const Eigen::Vector3d axis = base.R.col(2);
  if (std::abs(axis.z()) > kRounding) return std::nullopt;
  const std::optional<double> height = meeting_height(base.p, axis);
  if (!height) return std::nullopt;

  // From here on frame 1 has its origin where the two axes meet.
  const Eigen::Vector3d meeting = *height * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d origin_1{0.0, 0.0, (meeting - base.p).dot(axis)};
  const Circle wrist = circle_of(one.R, one.p - origin_1, two.p);
  const double size = wrist.c.norm() + wrist.a.norm();
  const double A = 2.0 * wrist.c.dot(wrist.a);
  const double B = 2.0 * wrist.c.dot(wrist.b);
  const double squares = wrist.c.squaredNorm() + wrist.a.squaredNorm();
  const auto add_postures = [&](double q2, Collector& collect) {
    const Circle circle = circle_of(base.R, meeting, wrist.at(q2));
    nearest_on_spherical_arc(circle, *height, problem.target, collect, q2);
  };

  const double out_of_plane = std::max({std::abs(wrist.c.z()), std::abs(wrist.a.z()), std::abs(wrist.b.z())});
  const double away = (problem.target - meeting).norm();
  if (out_of_plane <= kRounding * size) {
    Collector collect{problem, tie};
    if (std::hypot(A, B) <= kDegenerate) return std::nullopt;
    const Angles angles = angles_of(A, B, away * away - squares);
    for (int i = 0; i < angles.count; ++i) add_postures(angles.q[static_cast<std::size_t>(i)], collect);
    return collect.result();
  }
  const double swing = std::hypot(wrist.a.z(), wrist.b.z());
  if (std::hypot(A, B) <= kRounding * size * size && std::abs(wrist.c.z()) <= (1.0 - kDegenerate) * swing) {
    // With the tip in the plane through the meeting point every direction can be reached; further ones in part.
    Collector collect{problem, tie};
    add_postures(angles_of(wrist.a.z(), wrist.b.z(), -wrist.c.z()).q[0], collect);
    collect.family_along(2);
    return collect.result();
  }
  return std::nullopt;
}

}  // namespace

std::optional<ClosedForm> closed_form(const ReachProblem& problem, double tie) {
  for (int j = 0; j < problem.n; ++j) {
    if (!problem.links[static_cast<std::size_t>(j)].full_circle) return std::nullopt;
  }
  if (problem.n == 2) return of_two(problem, tie);
  if (problem.n == 3) return of_three(problem, tie);
  return std::nullopt;
}

}  // namespace modsearch::internal
