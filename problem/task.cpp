#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/problem/motion_choice_internal.hpp>
#include <modsearch/problem/task.hpp>
#include <modsearch/problem/trial_internal.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

using Kind = TaskStep::Kind;

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

// Whether a verdict against the arm is more than the end of a search. One without joints has no posture to search for,
// and a motion from a start that is asked for cannot begin where that touches something. Else nothing is settled: there
// may be other postures where these touch or are too heavy, and a planner that finds nothing proves nothing.
bool is_settled(const Task& task, const Arm& arm, const Scene& scene, bool sure_to_miss, Failure why) {
  if (sure_to_miss) return true;
  if (arm.n_joints() == 0) return !scene.any_moves();
  return why == Failure::kHomeInCollision && task.home().size() > 0;
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
  detail::Trial trial{*this, arm, scene, options};
  const std::vector<TaskStep> all_steps = steps_of(*this);
  for (const TaskStep& step : all_steps) {
    if (step.kind == Kind::kVisit) trial.seek(step.goal);
  }
  for (const TaskStep& step : all_steps) {
    if (step.kind == Kind::kVisit) trial.visit(step.goal);
    if (step.kind == Kind::kFollow) trial.follow(step);
  }
  Failure collision = trial.collision();
  const bool holds = trial.attempt().torque_share <= 1.0;
  if (options.level == Level::kPath && trial.attempt().reached && holds && collision == Failure::kNone) {
    collision = detail::plan_motion(*this, arm, scene, options, trial);
  }
  const bool sure_to_miss = trial.sure_to_miss();
  Attempt attempt = std::move(trial).result();
  attempt.collides = collision != Failure::kNone;
  if (attempt.why == Failure::kNone && !holds) attempt.why = Failure::kTorque;
  if (attempt.why == Failure::kNone) attempt.why = collision;
  attempt.achieved = attempt.why == Failure::kNone;
  attempt.inconclusive = !attempt.achieved && !is_settled(*this, arm, scene, sure_to_miss, attempt.why);
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
