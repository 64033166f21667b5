#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/edge_checker_internal.hpp>
#include <modsearch/kinematics/interruption.hpp>
#include <modsearch/kinematics/joint_box_internal.hpp>
#include <modsearch/kinematics/path_free.hpp>
#include <modsearch/kinematics/path_planning.hpp>
#include <modsearch/kinematics/rrt_connect_internal.hpp>
#include <modsearch/kinematics/shortcut_internal.hpp>
#include <optional>
#include <stdexcept>

namespace modsearch {
namespace {

void check_joints(const char* who, const char* which, const Arm& arm, const Eigen::VectorXd& q) {
  if (q.size() != arm.n_joints()) {
    throw std::invalid_argument(
        fmt::format("{}: {} has {} joint values, the arm {} joints", who, which, q.size(), arm.n_joints()));
  }
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    if (!std::isfinite(q[j])) throw std::invalid_argument(fmt::format("{}: {} of joint {} is {}", who, which, j, q[j]));
  }
}

void check_positive(const char* who, const char* what, double value) {
  if (!(std::isfinite(value) && value > 0.0)) {
    throw std::invalid_argument(fmt::format("{}: {} must be finite and > 0, is {}", who, what, value));
  }
}

bool within_limits(const Chain& chain, const Eigen::VectorXd& q) {
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    if (q[j] < joint.lower || q[j] > joint.upper) return false;
  }
  return true;
}

bool path_free(const std::vector<Eigen::VectorXd>& waypoints, EdgeChecker& checker) {
  if (!checker.state_free(waypoints.front().data())) return false;
  for (std::size_t i = 0; i + 1 < waypoints.size(); ++i) {
    if (!checker.edge_free(waypoints[i].data(), waypoints[i + 1].data())) return false;
  }
  return true;
}

Path path_of(const std::vector<Eigen::VectorXd>& waypoints) {
  Path path;
  path.waypoints.resize(static_cast<Eigen::Index>(waypoints.size()), waypoints.front().size());
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    path.waypoints.row(static_cast<Eigen::Index>(i)) = waypoints[i].transpose();
  }
  return path;
}

Plan planned(const Arm& arm, const Eigen::VectorXd& q_start, const Eigen::VectorXd& q_goal, const PlanOptions& options,
             const JointBox& box, EdgeChecker& checker) {
  Plan plan;
  if (!within_limits(arm.chain(), q_start) || !checker.state_free(q_start.data())) {
    plan.status = PlanStatus::kInvalidStart;
    return plan;
  }
  if (!within_limits(arm.chain(), q_goal) || !checker.state_free(q_goal.data())) {
    plan.status = PlanStatus::kInvalidGoal;
    return plan;
  }
  std::vector<Eigen::VectorXd> waypoints{q_start, q_goal};
  if (!checker.edge_free(q_start.data(), q_goal.data())) {
    RrtConnectResult found =
        rrt_connect(q_start, q_goal, box.lower, box.upper, options.max_iterations, options.stream, checker);
    plan.iterations = found.iterations;
    if (found.waypoints.empty()) return plan;
    waypoints = shortened(std::move(found.waypoints), options.shortcut_attempts, options.stream, checker);
    if (!path_free(waypoints, checker)) return plan;
  }
  plan.path = path_of(waypoints);
  plan.status = PlanStatus::kExact;
  return plan;
}

// Shows `look` the postures along `path`, between which no body point moves farther than `resolution`, until it returns
// false. Whether all waypoints are within the limits; nothing for an empty path.
template <typename Look>
std::optional<bool> walk(const char* who, const Arm& arm, const Path& path, double resolution, Look&& look) {
  check_positive(who, "resolution [m]", resolution);
  const Eigen::Index n_waypoints = path.waypoints.rows();
  if (n_waypoints == 0) return std::nullopt;
  std::vector<Eigen::VectorXd> waypoints;
  bool within = true;
  for (Eigen::Index i = 0; i < n_waypoints; ++i) {
    waypoints.emplace_back(path.waypoints.row(i).transpose());
    check_joints(who, "a waypoint", arm, waypoints.back());
    within = within && within_limits(arm.chain(), waypoints.back());
  }
  const MotionBound motion(arm, path.waypoints.colwise().minCoeff(), path.waypoints.colwise().maxCoeff());
  Posture posture;
  Eigen::VectorXd q = waypoints.front();
  arm.forward(q.data(), posture);
  if (!look(posture)) return within;
  for (std::size_t i = 0; i + 1 < waypoints.size(); ++i) {
    const double* a = waypoints[i].data();
    const double* b = waypoints[i + 1].data();
    const std::int64_t n = parts_of(motion.travel(a, b), resolution);
    for (std::int64_t k = 1; k <= n; ++k) {
      interruption_point();
      interpolate(a, b, k, n, arm.n_joints(), q.data());
      arm.forward(q.data(), posture);
      if (!look(posture)) return within;
    }
  }
  return within;
}

}  // namespace

std::string_view name(PlanStatus status) {
  switch (status) {
    case PlanStatus::kExact:
      return "exact";
    case PlanStatus::kNotFound:
      return "not found";
    case PlanStatus::kInvalidStart:
      return "invalid start";
    case PlanStatus::kInvalidGoal:
      return "invalid goal";
  }
  throw std::invalid_argument(fmt::format("PlanStatus: no such value: {}", static_cast<int>(status)));
}

Plan plan_path(const Arm& arm, const Scene& scene, const Eigen::VectorXd& q_start, const Eigen::VectorXd& q_goal,
               const PlanOptions& options) {
  check_joints("plan_path", "the start", arm, q_start);
  check_joints("plan_path", "the goal", arm, q_goal);
  check_positive("plan_path", "resolution [m]", options.resolution);
  if (options.max_iterations < 0 || options.shortcut_attempts < 0) {
    throw std::invalid_argument(fmt::format("plan_path: max_iterations ({}) and shortcut_attempts ({}) must be >= 0",
                                            options.max_iterations, options.shortcut_attempts));
  }
  const JointBox box = planning_box(arm.chain(), q_start, q_goal);
  EdgeChecker checker(arm, scene, box.lower, box.upper, options.resolution, options.self_collision);
  Plan plan = planned(arm, q_start, q_goal, options, box, checker);
  plan.work = checker.work();
  return plan;
}

PathCheck check_path(const Arm& arm, const Scene& scene, const Path& path, double resolution, bool self_collision) {
  PathCheck check;
  check.clearance = check.self_clearance = std::numeric_limits<double>::infinity();
  bool collides = false;
  const auto measure = [&](const Posture& posture) {
    check.clearance = scene.clearance(arm, posture, check.work, check.clearance);
    if (self_collision) check.self_clearance = self_clearance(arm, posture, check.work, check.self_clearance);
  };
  // Some states first: a distance is dear where it may be the least so far, and cheap where it cannot. Among meshes the
  // look at all of them then takes a fraction of the time.
  constexpr std::int64_t kEvery = 64;
  std::int64_t state = 0;
  static_cast<void>(walk("check_path", arm, path, resolution, [&](const Posture& posture) {
    if (state++ % kEvery == 0) measure(posture);
    return true;
  }));
  const std::optional<bool> within = walk("check_path", arm, path, resolution, [&](const Posture& posture) {
    ++check.work.forward;
    ++check.work.planner_states;
    collides = collides || scene.collides(arm, posture, check.work) ||
               (self_collision && self_collides(arm, posture, check.work));
    measure(posture);
    return true;
  });
  if (!within) return check;
  check.within_limits = *within;
  check.states = check.work.planner_states;
  check.free = check.within_limits && !collides;
  return check;
}

bool path_is_free(const Arm& arm, const Scene& scene, const Path& path, double resolution, bool self_collision,
                  Work& work) {
  bool collides = false;
  const std::optional<bool> within = walk("path_is_free", arm, path, resolution, [&](const Posture& posture) {
    ++work.forward;
    ++work.planner_states;
    collides = scene.collides(arm, posture, work) || (self_collision && self_collides(arm, posture, work));
    return !collides;
  });
  return within.value_or(false) && !collides;
}

}  // namespace modsearch
