#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/edge_checker_internal.hpp>
#include <modsearch/kinematics/interruption.hpp>
#include <modsearch/kinematics/self_pairs_internal.hpp>

#include "fcl_backend_internal.hpp"

namespace modsearch {
namespace {

constexpr double kCollision = -1.0;

// A lower bound of the distance of two shapes: kCollision, 0 if they are free and nothing else is known, else > 0.
// Asked after the overlap, because closed forms exist where two shapes are apart: for spheres and capsules against
// spheres, capsules and boxes. A cylinder lies within the capsule of its own length. For a mesh the balls around its
// triangles give a bound, before the dear verdict.
double distance_bound(const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b, const Eigen::Isometry3d& X_WB) {
  const bool mesh_a = std::holds_alternative<Mesh>(a);
  const bool mesh_b = std::holds_alternative<Mesh>(b);
  if (mesh_a != mesh_b) {
    if (const double least = detail::least_distance(a, X_WA, b, X_WB); least > 0.0) return least;
    return detail::mesh_touches(a, X_WA, b, X_WB) ? kCollision : 0.0;
  }
  if (overlaps(a, X_WA, b, X_WB)) return kCollision;
  if (std::holds_alternative<Cylinder>(b) || std::holds_alternative<Mesh>(b)) return 0.0;
  constexpr double kRounding = 1e-9;
  if (const auto* cylinder = std::get_if<Cylinder>(&a)) {
    const Shape capsule = Capsule{cylinder->radius, cylinder->length};
    return std::max(0.0, signed_distance(capsule, X_WA, b, X_WB) - kRounding);
  }
  const bool closed_form = std::holds_alternative<Sphere>(a) || std::holds_alternative<Capsule>(a);
  return closed_form ? std::max(0.0, signed_distance(a, X_WA, b, X_WB) - kRounding) : 0.0;
}

}  // namespace

std::int64_t parts_of(double travel, double resolution) {
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(travel / resolution)));
}

void interpolate(const double* a, const double* b, std::int64_t k, std::int64_t n, int n_joints, double* q) {
  const auto weight_a = static_cast<double>(n - k);
  const auto weight_b = static_cast<double>(k);
  for (int j = 0; j < n_joints; ++j) {
    const double mean = (a[j] * weight_a + b[j] * weight_b) / static_cast<double>(n);
    q[j] = k == 0 ? a[j] : k == n ? b[j] : std::clamp(mean, std::min(a[j], b[j]), std::max(a[j], b[j]));
  }
}

EdgeChecker::EdgeChecker(const Arm& arm, const Scene& scene, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                         double resolution, bool self_collision)
    : arm_{arm},
      scene_{scene},
      motion_{arm, lower, upper},
      resolution_{resolution},
      self_collision_{self_collision},
      poses_(arm.geometries().size(), Eigen::Isometry3d::Identity()),
      capsules_(arm.geometries().size()),
      travel_{Eigen::MatrixXd::Zero(arm.n_joints() + 1, static_cast<Eigen::Index>(arm.geometries().size()))},
      q_{arm.n_joints()} {}

bool EdgeChecker::state_free(const double* q) {
  ++work_.planner_states;
  ++work_.forward;
  arm_.forward(q, posture_);
  return !scene_.collides(arm_, posture_, work_) && !(self_collision_ && self_collides(arm_, posture_, work_));
}

bool EdgeChecker::edge_free(const double* a, const double* b) {
  const std::int64_t n = parts_of(motion_.travel(a, b), resolution_);
  measure_edge(a, b);
  // How many states on either side of state k are free as well; -1: state k is not.
  const auto free_neighbours = [&](std::int64_t k) -> std::int64_t {
    interpolate(a, b, k, n, arm_.n_joints(), q_.data());
    const double part = free_part(q_.data());
    return part < 0.0 ? -1 : static_cast<std::int64_t>(part * static_cast<double>(n));
  };

  const std::int64_t before_b = free_neighbours(n);
  if (before_b < 0) return false;
  ranges_.assign(1, {1, n - 1 - before_b});
  // Halving, widest gaps first: a collision is met early.
  for (std::size_t next = 0; next < ranges_.size(); ++next) {
    const Range range = ranges_[next];
    if (range.first > range.last) continue;
    const std::int64_t middle = range.first + (range.last - range.first) / 2;
    const std::int64_t around = free_neighbours(middle);
    if (around < 0) return false;
    ranges_.push_back({range.first, middle - around - 1});
    ranges_.push_back({middle + around + 1, range.last});
  }
  return true;
}

void EdgeChecker::measure_edge(const double* a, const double* b) {
  for (Eigen::Index g = 0; g < travel_.cols(); ++g) {
    for (int j = arm_.n_joints() - 1; j >= 0; --j) {
      travel_(j, g) = travel_(j + 1, g) + std::abs(b[j] - a[j]) * motion_.lever(static_cast<std::size_t>(g), j);
    }
  }
}

// The part of the edge, of length 1, on either side of the state that is certainly free; kCollision: none is.
double EdgeChecker::free_part(const double* q) {
  interruption_point();
  ++work_.planner_states;
  ++work_.forward;
  arm_.forward(q, posture_);
  for (std::size_t g = 0; g < poses_.size(); ++g) {
    const ArmGeometry& geometry = arm_.geometries()[g];
    poses_[g] = posture_.frames[static_cast<std::size_t>(geometry.frame)] * geometry.X_FG;
    capsules_[g] = bounding_capsule(geometry.shape, geometry.bounding_radius, poses_[g]);
  }
  double part = 1.0;
  const bool free = part_free_of_obstacles(part) && (!self_collision_ || part_free_of_self(part));
  return free ? part : kCollision;
}

bool EdgeChecker::part_free_of_obstacles(double& part) {
  for (std::size_t g = 0; g < poses_.size(); ++g) {
    const double travel = travel_(0, static_cast<Eigen::Index>(g));
    for (const Scene::Placed& placed : scene_.placed_) {
      if (balls_apart(capsules_[g], placed.capsule, part * travel)) continue;
      double bound = gap(capsules_[g], placed.capsule);
      if (bound <= 0.0) {
        const PlacedShape& obstacle = scene_.shape_of(placed);
        ++work_.distances;
        bound = distance_bound(arm_.geometries()[g].shape, poses_[g], obstacle.shape, obstacle.X_FG);
        if (bound < 0.0) return false;
      }
      if (bound < part * travel) part = bound / travel;
    }
  }
  return true;
}

bool EdgeChecker::part_free_of_self(double& part) {
  return !detail::any_self_pair(arm_, [&](std::size_t first, std::size_t second) {
    // Only the joints between the two move one against the other: seen from the inner body, only the outer one moves.
    const int frame_first = arm_.geometries()[first].frame;
    const int frame_second = arm_.geometries()[second].frame;
    const std::size_t outer = frame_second >= frame_first ? second : first;
    const double travel = travel_(std::min(frame_first, frame_second), static_cast<Eigen::Index>(outer));
    if (balls_apart(capsules_[first], capsules_[second], part * travel)) return false;
    double bound = gap(capsules_[first], capsules_[second]);
    if (bound <= 0.0) {
      ++work_.distances;
      bound = distance_bound(arm_.geometries()[first].shape, poses_[first], arm_.geometries()[second].shape,
                             poses_[second]);
      if (bound < 0.0) return true;
    }
    if (bound < part * travel) part = bound / travel;
    return false;
  });
}

}  // namespace modsearch
