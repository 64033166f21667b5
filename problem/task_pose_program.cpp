#include <algorithm>
#include <modsearch/problem/task_pose_program.hpp>
#include <vector>

namespace modsearch {
namespace {

std::vector<PoseRegion> regions_of(const Task& task) {
  std::vector<PoseRegion> regions;
  for (const Goal& goal : task.goals()) regions.push_back(goal.region);
  return regions;
}

}  // namespace

bool TaskPoseProgram::covers(const Task& task) {
  const bool follows = std::any_of(task.steps().begin(), task.steps().end(),
                                   [](const TaskStep& step) { return step.kind == TaskStep::Kind::kFollow; });
  return !follows && std::all_of(task.goals().begin(), task.goals().end(),
                                 [](const Goal& goal) { return SimultaneousIk::covers(goal.region); });
}

TaskPoseProgram::TaskPoseProgram(const RobotProblem& problem, std::span<const int> types)
    : problem_{problem},
      types_{types.begin(), types.end()},
      // Not from the problem's memory: of the sequences that poses are solved for, few are ever evaluated.
      chain_{std::make_shared<const Chain>(problem.library().assemble(types, problem.spec().X_WB))},
      n_goals_{static_cast<Eigen::Index>(problem.task().goals().size())},
      ik_{*chain_, regions_of(problem.task()), parameter_box(problem.library(), types).lower,
          parameter_box(problem.library(), types).upper} {}

bool TaskPoseProgram::asks_for_orientation() const {
  const std::span<const Goal> goals = problem_.task().goals();
  return std::any_of(goals.begin(), goals.end(), [](const Goal& goal) { return goal.region.constrains_orientation(); });
}

bool TaskPoseProgram::generic() { return ik_.generic(); }

PoseProgram::Outcome TaskPoseProgram::solve(int n_starts, const Start& start, const Arrival& arrival) {
  SimultaneousIk::Outcome outcome = ik_.solve(n_starts, start, arrival);
  return {outcome.steps, outcome.least_cost, std::move(outcome.nearest)};
}

Design TaskPoseProgram::design(const Eigen::VectorXd& v) const {
  return make_design(problem_.library(), types_, v.head(chain_->n_parameters()));
}

Witness TaskPoseProgram::witness(const Eigen::VectorXd& v) const {
  const Eigen::Index n_q = chain_->n_joints();
  return {.postures = v.tail(n_goals_ * n_q).reshaped(n_q, n_goals_).transpose()};
}

}  // namespace modsearch
