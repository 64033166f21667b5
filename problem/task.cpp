#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/problem/motion_internal.hpp>
#include <modsearch/problem/posture_choice_internal.hpp>
#include <modsearch/problem/reach_bound.hpp>
#include <modsearch/problem/task.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

using Kind = TaskStep::Kind;

// A limit keeps the arm from the pose: a joint that does not turn all round stands at its end.
bool at_a_limit(const Chain& chain, const Eigen::VectorXd& q) {
  constexpr double kAtTheEnd = 1e-9;  // [rad] or [m]
  for (int j = 0; j < chain.n_joints(); ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    if (!joint.full_circle() && (q[j] <= joint.lower + kAtTheEnd || q[j] >= joint.upper - kAtTheEnd)) return true;
  }
  return false;
}

// Fulfils goal by goal and trajectory by trajectory, and adds up what came of it.
class Trial {
 public:
  Trial(const Task& task, const Arm& arm, const Scene& scene, const AttemptOptions& options)
      : task_{task}, arm_{arm}, options_{options}, judge_{task, arm, scene, options} {
    attempt_.reached = true;
    attempt_.why = Failure::kNone;
    attempt_.postures.resize(static_cast<Eigen::Index>(task.goals().size()), arm.n_joints());
  }

  void visit(int index) {
    const Goal& goal = task_.goals()[static_cast<std::size_t>(index)];
    const IkSolution ik = inverse_kinematics(arm_, goal.region, judge_.ik());
    count(ik.iterations, ik.forward);
    ++errors_;
    attempt_.goal_error = std::max(attempt_.goal_error, ik.position_error);
    if (!ik.reached) miss(goal, ik);
    const detail::Candidate chosen = judge_.best(ik, load_at(task_, index), attempt_.work);
    attempt_.postures.row(index) = chosen.q.transpose();
    look_at(chosen);
  }

  // The arm may begin in one of several postures: the one from which it gets farthest counts, among those from which it
  // gets through the best one on the whole way.
  void follow(const TaskStep& step) {
    const std::vector<PoseRegion>& poses = step.trajectory->poses;
    const auto n = static_cast<double>(poses.size());
    IkOptions ik_options = options_.ik;  // the same starts at every level
    ik_options.all = true;
    ik_options.family_points = kMostStarts;
    const IkSolution ik = inverse_kinematics(arm_, poses.front(), ik_options);
    count(ik.iterations, ik.forward);
    ++errors_;
    std::optional<Following> best;
    detail::Candidate worst_of_best;
    if (ik.reached) {
      const std::size_t n_starts = std::min<std::size_t>(ik.postures.size(), kMostStarts);
      for (std::size_t i = 0; i < n_starts; ++i) {
        const std::size_t pick = i * ik.postures.size() / n_starts;
        Following way = follow_poses(arm_, poses, step.trajectory->times, ik.postures[pick], options_.follow);
        count(way.iterations, way.forward);
        if (best && way.n_followed < best->n_followed) continue;
        detail::Candidate worst = worst_along(way, step);
        if (best && way.n_followed == best->n_followed && !worst.better_than(worst_of_best)) continue;
        best = std::move(way);
        worst_of_best = std::move(worst);
        const bool free = worst_of_best.holds() && worst_of_best.clearance() >= 0.0;
        if (best->end == FollowEnd::kDone && free) break;  // any way that is free will do
      }
      attempt_.goal_error = std::max(attempt_.goal_error, best->position_error);
      look_at(worst_of_best);
      if (best->end != FollowEnd::kDone) {
        const Failure why = best->end == FollowEnd::kJump      ? Failure::kJump
                            : best->end == FollowEnd::kTooFast ? Failure::kLimit
                                                               : Failure::kUnreachable;
        fail(why, 1.0 - static_cast<double>(best->n_followed) / n);
      }
    } else {
      const Goal& goal = task_.goals()[static_cast<std::size_t>(step.goal)];
      attempt_.goal_error = std::max(attempt_.goal_error, ik.position_error);
      miss(goal, ik);
      attempt_.relative_error += 1.0;  // not even begun
      best.emplace();
      best->postures = ik.postures.front().transpose().replicate(static_cast<Eigen::Index>(poses.size()), 1);
    }
    for (int k = 0; k < step.n_goals; ++k) {
      attempt_.postures.row(step.goal + k) = best->postures.row(step.knots[static_cast<std::size_t>(k)]);
    }
    attempt_.trajectories.push_back(std::move(best->postures));
  }

  // What was seen, and whether the motion is worth planning: everything is reached and free.
  [[nodiscard]] Attempt result() && {
    attempt_.relative_error /= static_cast<double>(errors_);
    return std::move(attempt_);
  }
  [[nodiscard]] Failure collision() const { return collision_; }

 private:
  static constexpr int kMostStarts = 16;  // postures from which a trajectory is tried (arbitrary)

  void count(std::int64_t iterations, std::int64_t forward) {
    attempt_.work.ik_iterations += iterations;
    attempt_.work.forward += forward;
  }

  void fail(Failure why, double relative_error) {
    attempt_.reached = false;
    if (attempt_.why == Failure::kNone) attempt_.why = why;
    attempt_.relative_error += relative_error;
  }

  void miss(const Goal& goal, const IkSolution& ik) {
    constexpr double kRounding = 1e-9;  // [m]
    const double away = (goal.position() - arm_.segment(0).translation()).norm() - position_slack(goal.region);
    Failure why = Failure::kUnreachable;
    if (away > arm_.reach() + kRounding) {
      why = Failure::kProvedInfeasible;
    } else if (at_a_limit(arm_.chain(), ik.postures.front())) {
      why = Failure::kLimit;
    }
    fail(why, ik.position_error / std::max((goal.position() - options_.p_WB).norm(), 1e-9));
  }

  void look_at(const detail::Candidate& chosen) {
    attempt_.clearance = std::min(attempt_.clearance, chosen.obstacle_clearance);
    attempt_.torque_share = std::max(attempt_.torque_share, chosen.torque_share);
    if (collision_ == Failure::kNone && chosen.obstacle_clearance < 0.0) collision_ = Failure::kObstacle;
    if (collision_ == Failure::kNone && chosen.self_clearance < 0.0) collision_ = Failure::kSelfCollision;
  }

  // The least clearances and the largest share of a torque along the poses that were followed.
  [[nodiscard]] detail::Candidate worst_along(const Following& way, const TaskStep& step) {
    detail::Candidate worst;
    if (!judge_.choosy()) return worst;
    const StaticLoad load = load_at(task_, step.goal);
    for (std::size_t k = 0; k < way.n_followed; ++k) {
      const detail::Candidate at =
          judge_.judge(way.postures.row(static_cast<Eigen::Index>(k)).transpose(), load, attempt_.work);
      worst.obstacle_clearance = std::min(worst.obstacle_clearance, at.obstacle_clearance);
      worst.self_clearance = std::min(worst.self_clearance, at.self_clearance);
      worst.torque_share = std::max(worst.torque_share, at.torque_share);
    }
    return worst;
  }

  const Task& task_;
  const Arm& arm_;
  const AttemptOptions& options_;
  detail::PostureJudge judge_;
  Attempt attempt_;
  Failure collision_ = Failure::kNone;
  int errors_ = 0;  // goals and trajectories: what the relative error is the mean over
};

void check_steps(const GoalTaskSpec& spec) {
  const auto refuse = [&](const TaskStep& step, const std::string& what) {
    throw std::invalid_argument(fmt::format("task '{}': step '{}' {}", spec.name, step.id, what));
  };
  const auto n_goals = static_cast<int>(spec.goals.size());
  std::vector<bool> seen(spec.goals.size(), false);
  for (const TaskStep& step : spec.steps) {
    switch (step.kind) {
      case Kind::kVisit:
      case Kind::kFollow:
        if (step.goal < 0 || step.n_goals < 1 || step.goal + step.n_goals > n_goals) {
          refuse(step, fmt::format("has goals {} to {} of {}", step.goal, step.goal + step.n_goals - 1, n_goals));
        }
        if (step.kind == Kind::kFollow &&
            (!step.trajectory || step.knots.size() != static_cast<std::size_t>(step.n_goals))) {
          refuse(step, fmt::format("follows no trajectory with {} knots", step.n_goals));
        }
        for (int g = step.goal; g < step.goal + step.n_goals; ++g) {
          if (seen[static_cast<std::size_t>(g)]) refuse(step, fmt::format("shares goal {} with another step", g));
          seen[static_cast<std::size_t>(g)] = true;
        }
        break;
      case Kind::kReturn:
        if (step.goal >= n_goals) refuse(step, fmt::format("returns to goal {} of {}", step.goal, n_goals));
        if (!spec.any_order && step.goal >= 0 && !seen[static_cast<std::size_t>(step.goal)]) {
          refuse(step, fmt::format("returns to goal '{}', which comes later",
                                   spec.goals[static_cast<std::size_t>(step.goal)].id));
        }
        break;
      case Kind::kPause:
        if (!(step.duration >= 0.0) || !std::isfinite(step.duration)) {
          refuse(step, fmt::format("lasts {} s, must be finite and at least 0", step.duration));
        }
        break;
    }
  }
  const auto unseen = std::find(seen.begin(), seen.end(), false);
  if (!spec.steps.empty() && unseen != seen.end()) {
    throw std::invalid_argument(fmt::format("task '{}': no step has goal '{}'", spec.name,
                                            spec.goals[static_cast<std::size_t>(unseen - seen.begin())].id));
  }
}

}  // namespace

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
  Trial trial{*this, arm, scene, options};
  for (const TaskStep& step : steps()) {
    if (step.kind == Kind::kVisit) trial.visit(step.goal);
    if (step.kind == Kind::kFollow) trial.follow(step);
  }
  if (steps().empty()) {
    for (int goal = 0; goal < static_cast<int>(goals().size()); ++goal) trial.visit(goal);
  }
  Failure collision = trial.collision();
  Attempt attempt = std::move(trial).result();
  const bool holds = attempt.torque_share <= 1.0;
  if (options.level == Level::kPath && attempt.reached && holds && collision == Failure::kNone) {
    collision = detail::plan_motion(*this, arm, scene, options, attempt);
  }
  attempt.collides = collision != Failure::kNone;
  if (attempt.why == Failure::kNone && !holds) attempt.why = Failure::kTorque;
  if (attempt.why == Failure::kNone) attempt.why = collision;
  attempt.achieved = attempt.why == Failure::kNone;
  return attempt;
}

void Task::add_rows(RowSink&, const Chain&) const {}

GoalTask::GoalTask(GoalTaskSpec spec) : spec_{std::move(spec)} {
  if (spec_.goals.empty()) {
    throw std::invalid_argument(fmt::format("task '{}': no goals, at least one is needed", spec_.name));
  }
  if (!(spec_.statics.payload >= 0.0) || !spec_.statics.gravity.allFinite()) {
    throw std::invalid_argument(
        fmt::format("task '{}': a payload of {} kg, must be at least 0, and gravity must be finite", spec_.name,
                    spec_.statics.payload));
  }
  check_steps(spec_);
}

Eigen::VectorXd home_posture(const Task& task, const Chain& chain) {
  Eigen::VectorXd q = Eigen::VectorXd::Zero(chain.n_joints());
  const Eigen::VectorXd home = task.home();
  const Eigen::Index n = std::min(home.size(), q.size());
  q.head(n) = home.head(n);
  return chain.clamped(q);
}

std::vector<TaskStep> steps_of(const Task& task) {
  if (!task.steps().empty()) return {task.steps().begin(), task.steps().end()};
  std::vector<TaskStep> steps;
  for (const Goal& goal : task.goals()) {
    steps.push_back({.id = goal.id, .kind = Kind::kVisit, .goal = static_cast<int>(steps.size())});
  }
  return steps;
}

bool is_timed(const Task& task, const Scene& scene) {
  const auto has_times = [](const TaskStep& step) {
    return step.kind == Kind::kPause || (step.trajectory && !step.trajectory->times.empty());
  };
  return scene.any_moves() || std::any_of(task.steps().begin(), task.steps().end(), has_times);
}

StaticLoad load_at(const Task& task, int goal) {
  const Statics statics = task.statics();
  return {statics.gravity, statics.payload, task.goals()[static_cast<std::size_t>(goal)].wrench};
}

}  // namespace modsearch
