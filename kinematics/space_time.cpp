#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/edge_checker_internal.hpp>
#include <modsearch/kinematics/fixed_stream_internal.hpp>
#include <modsearch/kinematics/interruption.hpp>
#include <modsearch/kinematics/joint_box_internal.hpp>
#include <modsearch/kinematics/pose_following.hpp>
#include <modsearch/kinematics/space_time.hpp>
#include <optional>
#include <stdexcept>

namespace modsearch {
namespace {

// A posture at a time.
struct Moment {
  Eigen::VectorXd q;
  double t = 0.0;
};

// Calls visit(geometry, its pose, shape, its pose) for every pair of a shape of the arm and one of a moving obstacle at
// time t whose capsules are not farther apart than distance(), until one returns true.
template <typename Distance, typename Visit>
bool any_pair_at(const Arm& arm, const Posture& posture, const Scene& scene, double t, Distance&& distance,
                 Visit&& visit) {
  for (const Obstacle& obstacle : scene.obstacles()) {
    if (!obstacle.moves()) continue;
    const Eigen::Isometry3d X_WO = obstacle.motion.at(t);
    for (const PlacedShape& placed : obstacle.shapes) {
      const Eigen::Isometry3d X_WS = X_WO * placed.X_FG;
      const BoundingCapsule theirs = bounding_capsule(placed.shape, bounding_radius(placed.shape), X_WS);
      for (const ArmGeometry& geometry : arm.geometries()) {
        const Eigen::Isometry3d X_WG = posture.frames[static_cast<std::size_t>(geometry.frame)] * geometry.X_FG;
        if (apart(bounding_capsule(geometry.shape, geometry.bounding_radius, X_WG), theirs, distance())) continue;
        if (visit(geometry.shape, X_WG, placed.shape, X_WS)) return true;
      }
    }
  }
  return false;
}

bool collides_at(const Arm& arm, const Posture& posture, const Scene& scene, double t, Work& work) {
  return any_pair_at(
      arm, posture, scene, t, [] { return 0.0; },
      [&](const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b, const Eigen::Isometry3d& X_WB) {
        ++work.distances;
        return overlaps(a, X_WA, b, X_WB);
      });
}

// No point of an obstacle that moves travels farther between two times [m].
double obstacle_way(const Scene& scene, double from, double to) {
  double way = 0.0;
  for (const Obstacle& obstacle : scene.obstacles()) {
    double reach = 0.0;  // of its shapes, from its origin
    for (const PlacedShape& placed : obstacle.shapes) {
      reach = std::max(reach, placed.X_FG.translation().norm() + bounding_radius(placed.shape));
    }
    way = std::max(way, obstacle.motion.fastest(reach, from, to) * (to - from));
  }
  return way;
}

// Straight lines in joints and time among everything: the obstacles that rest, the arm itself, those that move.
class TimedChecker {
 public:
  TimedChecker(const Arm& arm, const Scene& scene, const JointBox& box, const PlanOptions& options)
      : arm_{arm},
        scene_{scene},
        motion_{arm, box.lower, box.upper},
        resting_{arm, scene, box.lower, box.upper, options.resolution, options.self_collision},
        resolution_{options.resolution} {}

  [[nodiscard]] bool state_free(const Moment& at) {
    if (!resting_.state_free(at.q.data())) return false;
    arm_.forward(at.q.data(), posture_);
    return !collides_at(arm_, posture_, scene_, at.t, work_);
  }

  // Of which `a` is known to be free.
  [[nodiscard]] bool edge_free(const Moment& a, const Moment& b) {
    if (a.q != b.q && !resting_.edge_free(a.q.data(), b.q.data())) return false;
    const double way = motion_.travel(a.q.data(), b.q.data()) + obstacle_way(scene_, a.t, b.t);
    const std::int64_t n = parts_of(way, resolution_);
    Eigen::VectorXd q(a.q.size());
    for (std::int64_t k = 1; k <= n; ++k) {
      interruption_point();
      interpolate(a.q.data(), b.q.data(), k, n, arm_.n_joints(), q.data());
      arm_.forward(q.data(), posture_);
      ++work_.forward;
      ++work_.planner_states;
      const double t = a.t + (b.t - a.t) * static_cast<double>(k) / static_cast<double>(n);
      if (collides_at(arm_, posture_, scene_, t, work_)) return false;
    }
    return true;
  }

  [[nodiscard]] Work work() const {
    Work total = resting_.work();
    total += work_;
    return total;
  }

 private:
  const Arm& arm_;
  const Scene& scene_;
  MotionBound motion_;
  EdgeChecker resting_;
  double resolution_;
  Work work_;
  Posture posture_;
};

Path path_of(const std::vector<Moment>& moments) {
  Path path;
  path.waypoints.resize(static_cast<Eigen::Index>(moments.size()), moments.front().q.size());
  for (std::size_t i = 0; i < moments.size(); ++i) {
    path.waypoints.row(static_cast<Eigen::Index>(i)) = moments[i].q.transpose();
    path.times.push_back(moments[i].t);
  }
  return path;
}

class TimedSearch {
 public:
  TimedSearch(const Arm& arm, TimedChecker& checker, const JointBox& box, const Eigen::VectorXd& q_goal, double hold,
              const TimedPlanOptions& options)
      : arm_{arm}, checker_{checker}, box_{box}, q_goal_{q_goal}, hold_{hold}, options_{options} {}

  [[nodiscard]] std::vector<Moment> from(const Moment& start) {
    latest_ = start.t + options_.horizon;
    if (std::vector<Moment> path = waiting_first(start); !path.empty()) return path;
    return tree(start);
  }
  [[nodiscard]] std::int64_t iterations() const { return iterations_; }

 private:
  // At full speed from `at` to the goal, and standing there; the end of the motion, or nothing.
  [[nodiscard]] std::optional<Moment> straight(const Moment& at) {
    const Moment there{q_goal_, at.t + travel_time(arm_.chain(), at.q, q_goal_)};
    if (there.t > latest_ || !checker_.edge_free(at, there)) return std::nullopt;
    if (hold_ > 0.0 && !checker_.edge_free(there, {q_goal_, there.t + hold_})) return std::nullopt;
    return there;
  }

  [[nodiscard]] std::vector<Moment> waiting_first(const Moment& start) {
    constexpr double kWait = 0.25;  // [s], arbitrary
    Moment ready = start;
    for (;;) {
      if (const std::optional<Moment> there = straight(ready)) {
        if (ready.t == start.t) return {start, *there};
        return {start, ready, *there};
      }
      const Moment later{start.q, ready.t + kWait};
      if (later.t > latest_ || !checker_.edge_free(ready, later)) return {};
      ready = later;
    }
  }

  [[nodiscard]] std::vector<Moment> tree(const Moment& start) {
    constexpr double kStep = 0.5;     // [s] of one edge at most (arbitrary)
    constexpr double kWaiting = 0.1;  // a second of waiting counts as much as this much motion (arbitrary)
    struct Node {
      Moment at;
      std::size_t parent;
    };
    std::vector<Node> nodes{{start, 0}};
    FixedStream numbers{options_.plan.stream};
    const Eigen::Index n = start.q.size();
    while (iterations_ < options_.plan.max_iterations) {
      interruption_point();
      ++iterations_;
      Moment aim{q_goal_, start.t + numbers.next() * options_.horizon};
      const bool at_goal = numbers.next() < 0.1;
      for (Eigen::Index j = 0; j < n; ++j) {
        const double u = numbers.next();
        if (!at_goal) aim.q[j] = box_.lower[j] + u * (box_.upper[j] - box_.lower[j]);
      }
      std::size_t nearest = nodes.size();
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (nodes[i].at.t >= aim.t) continue;
        const double cost = travel_time(arm_.chain(), nodes[i].at.q, aim.q) + kWaiting * (aim.t - nodes[i].at.t);
        if (cost < least) {
          least = cost;
          nearest = i;
        }
      }
      if (nearest == nodes.size()) continue;
      const Moment from = nodes[nearest].at;
      const double duration = std::min(kStep, aim.t - from.t);
      const double travel = travel_time(arm_.chain(), from.q, aim.q);
      const double part = travel > duration ? duration / travel : 1.0;
      const Moment to{from.q + part * (aim.q - from.q), from.t + duration};
      if (!checker_.edge_free(from, to)) continue;
      nodes.push_back({to, nearest});
      const std::optional<Moment> there = straight(to);
      if (!there) continue;
      std::vector<Moment> path{*there};
      for (std::size_t i = nodes.size() - 1; i != 0; i = nodes[i].parent) path.push_back(nodes[i].at);
      path.push_back(start);
      std::reverse(path.begin(), path.end());
      return path;
    }
    return {};
  }

  const Arm& arm_;
  TimedChecker& checker_;
  const JointBox& box_;
  const Eigen::VectorXd& q_goal_;
  double hold_;
  const TimedPlanOptions& options_;
  double latest_ = 0.0;
  std::int64_t iterations_ = 0;
};

}  // namespace

double clearance_at(const Arm& arm, const Posture& posture, const Scene& scene, double t, Work& work, double ceiling) {
  double least = ceiling;
  any_pair_at(
      arm, posture, scene, t, [&] { return least; },
      [&](const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b, const Eigen::Isometry3d& X_WB) {
        ++work.distances;
        least = std::min(least, signed_distance(a, X_WA, b, X_WB));
        return false;
      });
  return least;
}

SpaceTimeCheck check_in_time(const Arm& arm, const Scene& scene, const Path& path, double resolution) {
  const auto n_rows = static_cast<std::size_t>(path.waypoints.rows());
  if (path.times.size() != n_rows || path.waypoints.cols() != arm.n_joints() || !(resolution > 0.0)) {
    throw std::invalid_argument(
        fmt::format("check_in_time: {} times for {} waypoints of {} joints, the arm has {}, resolution {} m",
                    path.times.size(), n_rows, path.waypoints.cols(), arm.n_joints(), resolution));
  }
  SpaceTimeCheck check;
  check.clearance = std::numeric_limits<double>::infinity();
  if (n_rows == 0) return check;
  const MotionBound motion(arm, path.waypoints.colwise().minCoeff(), path.waypoints.colwise().maxCoeff());
  Posture posture;
  const auto look = [&](const Eigen::VectorXd& q, double t) {
    arm.forward(q.data(), posture);
    check.clearance = clearance_at(arm, posture, scene, t, check.work, check.clearance);
    ++check.states;
  };
  Eigen::VectorXd a = path.waypoints.row(0).transpose();
  look(a, path.times.front());
  for (std::size_t i = 1; i < n_rows; ++i) {
    const Eigen::VectorXd b = path.waypoints.row(static_cast<Eigen::Index>(i)).transpose();
    const double from = path.times[i - 1], to = path.times[i];
    if (to < from) throw std::invalid_argument(fmt::format("check_in_time: time {} is {} s after {} s", i, to, from));
    const std::int64_t n = parts_of(motion.travel(a.data(), b.data()) + obstacle_way(scene, from, to), resolution);
    Eigen::VectorXd q(arm.n_joints());
    for (std::int64_t k = 1; k <= n; ++k) {
      interpolate(a.data(), b.data(), k, n, arm.n_joints(), q.data());
      look(q, from + (to - from) * static_cast<double>(k) / static_cast<double>(n));
    }
    a = b;
  }
  check.free = check.clearance >= 0.0;
  return check;
}

Plan plan_in_time(const Arm& arm, const Scene& scene, const Eigen::VectorXd& q_start, double t_start,
                  const Eigen::VectorXd& q_goal, double hold, const TimedPlanOptions& options) {
  const auto fits = [&](const Eigen::VectorXd& q) { return q.size() == arm.n_joints() && q.allFinite(); };
  if (!fits(q_start) || !fits(q_goal) || !std::isfinite(t_start) || !(hold >= 0.0)) {
    throw std::invalid_argument(fmt::format(
        "plan_in_time: needs {} finite joint values for start ({}) and goal ({}), a time ({}) and hold >= 0 ({})",
        arm.n_joints(), q_start.size(), q_goal.size(), t_start, hold));
  }
  const JointBox box = planning_box(arm.chain(), q_start, q_goal);
  TimedChecker checker{arm, scene, box, options.plan};
  Plan plan;
  const Moment start{q_start, t_start};
  if (arm.chain().clamped(q_start) != q_start || !checker.state_free(start)) {
    plan.status = PlanStatus::kInvalidStart;
  } else if (arm.chain().clamped(q_goal) != q_goal) {
    plan.status = PlanStatus::kInvalidGoal;
  } else {
    TimedSearch search{arm, checker, box, q_goal, hold, options};
    const std::vector<Moment> moments = search.from(start);
    plan.iterations = search.iterations();
    if (!moments.empty()) {
      plan.path = path_of(moments);
      plan.status = PlanStatus::kExact;
    }
  }
  plan.work = checker.work();
  return plan;
}

}  // namespace modsearch
