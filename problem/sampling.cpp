#include <fmt/format.h>

#include <algorithm>
#include <modsearch/problem/readers_internal.hpp>
#include <modsearch/problem/whitman.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

// Where even this many draws fail, less than a thousandth of the box is far enough from the obstacles.
constexpr int kMostDraws = 10'000;

/// A point of the box that is far enough from the obstacles: the first of the stream that belongs to `instance`.
Eigen::Vector3d draw_target(const Sampling& sampling, const Scene& scene, Instance instance,
                            const std::string& problem) {
  Rng rng = Rng{instance.seed}.fork("instance").fork(instance.index);
  for (int draw = 0; draw < kMostDraws; ++draw) {
    Eigen::Vector3d p_W;
    for (int axis = 0; axis < 3; ++axis) p_W[axis] = rng.uniform(sampling.lower[axis], sampling.upper[axis]);
    if (!(scene.clearance(p_W) < sampling.min_clearance)) return p_W;
  }
  throw std::runtime_error(fmt::format("{}: instance {}:{}: {} targets in a row are closer than {} m to an obstacle",
                                       problem, instance.seed, instance.index, kMostDraws, sampling.min_clearance));
}

}  // namespace

std::shared_ptr<const RobotProblem> ProblemFile::instance(Instance instance) const {
  if (whitman) {
    RobotProblemSpec drawn = spec;
    TaskFile task = detail::read_task_text(whitman_task(*whitman, instance), spec.name);
    drawn.task = std::move(task.task);
    drawn.scene = std::move(task.scene);
    return std::make_shared<const RobotProblem>(std::move(drawn));
  }
  if (!sampling) return std::make_shared<const RobotProblem>(spec);

  std::vector<Goal> moved = goals;
  const auto goal =
      std::find_if(moved.begin(), moved.end(), [&](const Goal& each) { return each.id == sampling->goal; });
  if (goal == moved.end()) {
    throw std::invalid_argument(
        fmt::format("problem '{}': there is no goal '{}' to sample", spec.name, sampling->goal));
  }
  Eigen::Isometry3d X_WN = goal->region.nominal();
  X_WN.translation() = draw_target(*sampling, *spec.scene, instance, spec.name);
  goal->region = PoseRegion{X_WN, goal->region.tolerances()};

  RobotProblemSpec drawn = spec;
  GoalTaskSpec task{.name = std::string{spec.task->name()}, .goals = std::move(moved), .home = spec.task->home()};
  task.steps.assign(spec.task->steps().begin(), spec.task->steps().end());
  task.any_order = spec.task->any_order();
  task.statics = spec.task->statics();
  drawn.task = std::make_shared<const GoalTask>(std::move(task));
  return std::make_shared<const RobotProblem>(std::move(drawn));
}

}  // namespace modsearch
