#include <fmt/format.h>

#include <algorithm>
#include <modsearch/problem/readers_internal.hpp>
#include <modsearch/problem/whitman.hpp>

namespace modsearch {
namespace detail {
namespace {

/// A document that stands in place or is named by a file relative to this one.
TaskFile read_task_of(const JsonCursor& cursor) {
  if (!cursor.value().is_string()) return read_task(cursor);
  const std::filesystem::path file = cursor.source().directory / cursor.text();
  return read_task(load_json(file, cursor.source().label, cursor.source().mesh_root).cursor());
}

std::shared_ptr<const ModuleLibrary> read_library_of(const JsonCursor& cursor, const std::string& problem) {
  if (!cursor.value().is_string()) return read_library(cursor, problem);
  return load_library_from(cursor.text(), cursor.source());
}

Sampling read_sampling(const JsonCursor& cursor, const std::vector<Goal>& goals) {
  cursor.expect_keys({"goal", "box", "minClearance"});
  Sampling sampling;
  sampling.goal = cursor.at("goal").text();
  const bool known = std::any_of(goals.begin(), goals.end(), [&](const Goal& goal) {
    return goal.id == sampling.goal && goal.type != GoalType::kFollow;
  });
  if (!known) cursor.at("goal").fail_value("the ID of a goal of the task");
  const JsonCursor box = cursor.at("box");
  box.expect_keys({"lower", "upper"});
  sampling.lower = box.at("lower").vector(3);
  sampling.upper = box.at("upper").vector(3);
  for (int axis = 0; axis < 3; ++axis) {
    if (sampling.lower[axis] > sampling.upper[axis]) {
      box.at("upper").items()[static_cast<std::size_t>(axis)].fail_value(
          fmt::format("at least {}, the lower end", sampling.lower[axis]));
    }
  }
  sampling.min_clearance = cursor.number_or("minClearance", 0.0);
  return sampling;
}

WhitmanTasks read_whitman(const JsonCursor& cursor, const std::shared_ptr<const ModuleLibrary>& library) {
  cursor.expect_keys({"whitman"});
  const JsonCursor given = cursor.at("whitman");
  given.expect_keys({"goals", "boxes", "freeEnds"});
  WhitmanTasks tasks{.goals = static_cast<int>(given.at("goals").integer(1, 20)),
                     .boxes = static_cast<int>(given.at("boxes").integer(1, 20))};
  if (given.has("freeEnds") && given.at("freeEnds").boolean()) {
    if (!library->has_end_effectors()) given.at("freeEnds").fail("the library has no end effector");
    tasks.free_ends = library;
  }
  return tasks;
}

ProblemFile read_problem(const JsonCursor& cursor, const std::string& name) {
  cursor.expect_keys({"modsearch", "task", "library", "maxModules", "collision", "scoring", "sampling"});
  static_cast<void>(cursor.at("modsearch").integer(1, 1));
  ProblemFile result;
  result.spec.name = name;
  result.spec.library = read_library_of(cursor.at("library"), name);
  if (const std::optional<JsonCursor> sampling = cursor.find("sampling"); sampling && sampling->has("whitman")) {
    result.whitman = read_whitman(*sampling, result.spec.library);
    if (cursor.has("task")) cursor.at("task").fail("the tasks are generated, so none may be given");
  }
  TaskFile task =
      result.whitman ? read_task_text(whitman_task(*result.whitman, {}), name) : read_task_of(cursor.at("task"));
  if (task.goals.empty()) cursor.at("task").fail("the task has no goals (limit: at least 1)");
  result.spec.task = std::move(task.task);
  result.spec.scene = std::move(task.scene);
  result.spec.X_WB = task.X_WB;
  if (task.base) {
    const JsonCursor place = cursor.at("task");
    result.spec.library = place.guard(
        [&] { return std::make_shared<const ModuleLibrary>(with_placed_base(*result.spec.library, *task.base)); });
    result.spec.placed_base = true;
  }
  result.goals = std::move(task.goals);
  result.spec.time_step = task.time_step;
  result.spec.max_modules = static_cast<int>(cursor.at("maxModules").integer(1, 64));
  constexpr Level kLevels[] = {Level::kNone, Level::kPosture, Level::kPostureSelf, Level::kPath};
  result.spec.level = kLevels[cursor.at("collision").choice({"none", "posture", "posture+self", "path"})];
  result.spec.scoring = read_scoring(cursor.at("scoring"));
  if (const std::optional<JsonCursor> sampling = cursor.find("sampling"); sampling && !result.whitman) {
    result.sampling = read_sampling(*sampling, result.goals);
  }
  result.spec.chains = RobotProblem{result.spec}.spec().chains;  // shared by all instances
  return result;
}

}  // namespace

std::shared_ptr<const Scoring> read_scoring(const JsonCursor& cursor) {
  if (cursor.at("type").choice({"algorithm1", "weighted"}) == 0) {
    cursor.expect_keys({"type"});
    return std::make_shared<const Algorithm1>();
  }
  cursor.expect_keys({"type", "reached", "distance", "module", "mass", "cost", "collision"});
  const auto weight = [&](const char* key) { return cursor.number_or(key, 0.0, {.lower = 0.0}); };
  return cursor.guard([&] {
    return std::make_shared<const WeightedScoring>(WeightedScoring::Weights{.reached = weight("reached"),
                                                                            .distance = weight("distance"),
                                                                            .module = weight("module"),
                                                                            .mass = weight("mass"),
                                                                            .cost = weight("cost"),
                                                                            .collision = weight("collision")});
  });
}

}  // namespace detail

ProblemFile load_problem_file(const std::string& file_or_id, const FileOptions& options) {
  if (const std::optional<std::string_view> text = detail::builtin_problem(file_or_id)) {
    const detail::JsonDocument document =
        detail::parse_json(std::string{*text}, {"built-in problem " + file_or_id, {}});
    return detail::read_problem(document.cursor(), file_or_id);
  }
  detail::require_file_or_id(file_or_id, "problem", builtin_problems());
  return detail::read_problem(detail::load_json(file_or_id, {}, options.mesh_root).cursor(), file_or_id);
}

std::shared_ptr<const RobotProblem> load_problem(const std::string& file_or_id, Instance instance,
                                                 const FileOptions& options) {
  return load_problem_file(file_or_id, options).instance(instance);
}

}  // namespace modsearch
