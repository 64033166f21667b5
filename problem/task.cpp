#include <modsearch/problem/task.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace modsearch {
namespace {

// A posture for a goal, and how it stands to what it must not touch.
struct Candidate {
  Eigen::VectorXd q;
  double obstacle_clearance = std::numeric_limits<double>::infinity();
  double self_clearance = std::numeric_limits<double>::infinity();

  [[nodiscard]] double clearance() const { return std::min(obstacle_clearance, self_clearance); }
};

bool looks_at_obstacles(Level level) { return level != Level::kNone; }
bool looks_at_itself(Level level) { return level == Level::kPostureSelf || level == Level::kPath; }

// `posture`: memory to work in, kept between calls.
Candidate candidate(const Arm& arm, const Scene& scene, Level level, const Eigen::VectorXd& q, Posture& posture,
                    Work& work) {
  Candidate result{.q = q};
  if (!looks_at_obstacles(level)) return result;
  arm.forward(q.data(), posture);
  ++work.forward;
  result.obstacle_clearance = scene.clearance(arm, posture, work);
  if (looks_at_itself(level)) result.self_clearance = self_clearance(arm, posture, work);
  return result;
}

// Among equally close postures the one with the largest clearance counts; the first of these if several tie.
Candidate best_candidate(const Arm& arm, const Scene& scene, Level level, const IkSolution& ik, Work& work) {
  Posture posture;
  Candidate best = candidate(arm, scene, level, ik.postures.front(), posture, work);
  for (std::size_t i = 1; i < ik.postures.size(); ++i) {
    Candidate other = candidate(arm, scene, level, ik.postures[i], posture, work);
    if (other.clearance() > best.clearance()) best = std::move(other);
  }
  return best;
}

// Whether turning the frame of the shape about its z axis leaves the shape where it is.
bool turns_invisibly(const ArmGeometry& geometry) {
  constexpr double kRounding = 1e-12;  // [m]: a body moves by less than that
  const Eigen::Vector3d centre = geometry.X_FG.translation();
  const Eigen::Vector3d axis = geometry.X_FG.linear().col(2);
  if (std::hypot(centre.x(), centre.y()) > kRounding) return false;
  if (std::holds_alternative<Sphere>(geometry.shape)) return true;
  const Shape& shape = geometry.shape;
  if (!std::holds_alternative<Cylinder>(shape) && !std::holds_alternative<Capsule>(shape)) return false;
  return std::hypot(axis.x(), axis.y()) <= kRounding;
}

// Whether bodies move when two neighbouring joints about one line share a turn differently: only those between the two.
bool shared_turns_show(const Arm& arm) {
  constexpr double kNearlyCoaxial = 1e-9;  // wider than what inverse kinematics takes for one line
  const auto coaxial_with_next = [&](int j) {
    const Joint* joint = arm.chain().joints().data() + j;
    if (!joint[0].rotates() || !joint[1].rotates()) return false;
    const Eigen::Isometry3d& X = arm.segment(j + 1);
    return std::hypot(X(0, 2), X(1, 2)) < kNearlyCoaxial && std::hypot(X(0, 3), X(1, 3)) < kNearlyCoaxial;
  };
  return std::any_of(arm.geometries().begin(), arm.geometries().end(), [&](const ArmGeometry& geometry) {
    const int j = geometry.frame - 1;  // the joint that moves it
    return j >= 0 && j + 1 < arm.n_joints() && coaxial_with_next(j) && !turns_invisibly(geometry);
  });
}

// Whether turning the only joint moves anything that can be seen: an arm of links on a turning base does not.
bool single_turn_shows(const Arm& arm) {
  if (arm.n_joints() != 1 || !arm.chain().joints().front().rotates()) return true;
  return !std::all_of(arm.geometries().begin(), arm.geometries().end(),
                      [](const ArmGeometry& geometry) { return geometry.frame == 0 || turns_invisibly(geometry); });
}

// Nothing can collide: one posture is as good as another.
bool clearance_matters(const Arm& arm, const Scene& scene, Level level) {
  return (looks_at_obstacles(level) && !scene.obstacles().empty()) ||
         (looks_at_itself(level) && !arm.chain().self_pairs().empty());
}

// Extends the attempt by a motion from home through all goals; says what is wrong if there is none.
Failure plan_motion(const Arm& arm, const Scene& scene, const AttemptOptions& options, const Eigen::VectorXd& home,
                    Attempt& attempt) {
  std::vector<Eigen::VectorXd> waypoints{home};
  for (Eigen::Index goal = 0; goal < attempt.postures.rows(); ++goal) {
    const Eigen::VectorXd target = attempt.postures.row(goal).transpose();
    const Plan plan = plan_path(arm, scene, waypoints.back(), target, options.planner);
    attempt.work += plan.work;
    switch (plan.status) {
      case PlanStatus::kExact:
        break;
      case PlanStatus::kInvalidStart:
        return goal == 0 ? Failure::kHomeInCollision : Failure::kNoPath;
      case PlanStatus::kInvalidGoal:
      case PlanStatus::kNotFound:
        return Failure::kNoPath;
    }
    for (Eigen::Index row = 1; row < plan.path.waypoints.rows(); ++row) {
      waypoints.emplace_back(plan.path.waypoints.row(row).transpose());
    }
    attempt.goal_waypoints.push_back(static_cast<int>(waypoints.size()) - 1);
  }
  Path path;
  path.waypoints.resize(static_cast<Eigen::Index>(waypoints.size()), home.size());
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    path.waypoints.row(static_cast<Eigen::Index>(i)) = waypoints[i].transpose();
  }
  attempt.path = std::move(path);
  return Failure::kNone;
}

}  // namespace

std::string_view name(GoalType type) {
  switch (type) {
    case GoalType::kAt:
      return "at";
    case GoalType::kReach:
      return "reach";
  }
  return "";
}

Eigen::VectorXd Task::features() const {
  // Two metres are about the reach of one module of the reference library: keeps the numbers near [-1, 1].
  constexpr double kScale = 0.5;
  Eigen::VectorXd result(3 * static_cast<Eigen::Index>(goals().size()));
  Eigen::Index at = 0;
  for (const Goal& goal : goals()) {
    result.segment<3>(at) = kScale * goal.position();
    at += 3;
  }
  return result;
}

Attempt Task::attempt(const Arm& arm, const Scene& scene, const AttemptOptions& options) const {
  Attempt attempt;
  attempt.reached = true;
  attempt.why = Failure::kNone;
  attempt.postures.resize(static_cast<Eigen::Index>(goals().size()), arm.n_joints());
  IkOptions ik_options = options.ik;
  const bool choosy = clearance_matters(arm, scene, options.level);
  // Postures that place every body alike need not be told apart.
  ik_options.all = choosy && single_turn_shows(arm);
  ik_options.shared_turns = options.ik.shared_turns && shared_turns_show(arm);

  Failure collision = Failure::kNone;
  Eigen::Index row = 0;
  for (const Goal& goal : goals()) {
    const IkSolution ik = inverse_kinematics(arm, goal.region, ik_options);
    attempt.work.ik_iterations += ik.iterations;
    attempt.work.forward += ik.forward;
    attempt.goal_error = std::max(attempt.goal_error, ik.position_error);
    if (!ik.reached) {
      attempt.reached = false;
      attempt.why = Failure::kUnreachable;
      attempt.relative_error += ik.position_error / std::max((goal.position() - options.p_WB).norm(), 1e-9);
    }
    const Candidate chosen =
        choosy ? best_candidate(arm, scene, options.level, ik, attempt.work) : Candidate{.q = ik.postures.front()};
    attempt.postures.row(row++) = chosen.q.transpose();
    attempt.clearance = std::min(attempt.clearance, chosen.obstacle_clearance);
    if (collision == Failure::kNone && chosen.obstacle_clearance < 0.0) collision = Failure::kObstacle;
    if (collision == Failure::kNone && chosen.self_clearance < 0.0) collision = Failure::kSelfCollision;
  }
  attempt.relative_error /= static_cast<double>(goals().size());

  if (options.level == Level::kPath && attempt.reached && collision == Failure::kNone) {
    collision = plan_motion(arm, scene, options, home_posture(*this, arm.chain()), attempt);
  }
  attempt.collides = collision != Failure::kNone;
  if (attempt.why == Failure::kNone) attempt.why = collision;
  attempt.achieved = attempt.why == Failure::kNone;
  return attempt;
}

void Task::add_rows(RowSink&, const Chain&) const {}

GoalTask::GoalTask(std::string name, std::vector<Goal> goals, Eigen::VectorXd home)
    : name_{std::move(name)}, goals_{std::move(goals)}, home_{std::move(home)} {
  if (goals_.empty()) throw std::invalid_argument(fmt::format("task '{}': no goals, at least one is needed", name_));
}

Eigen::VectorXd home_posture(const Task& task, const Chain& chain) {
  Eigen::VectorXd q = Eigen::VectorXd::Zero(chain.n_joints());
  const Eigen::VectorXd home = task.home();
  const Eigen::Index n = std::min(home.size(), q.size());
  q.head(n) = home.head(n);
  return chain.clamped(q);
}

}  // namespace modsearch
