#include <fmt/format.h>

#include <algorithm>
#include <modsearch/study/study_csv.hpp>

#include "csv_fields_internal.hpp"

namespace modsearch {
namespace {

std::string instance_fields(const CellKey& key) {
  return key.instance ? fmt::format("{},{}", key.instance->seed, key.instance->index) : std::string{","};
}

// What was found; a training finds no design.
std::string design_fields(const CellOutcome& outcome) {
  if (outcome.training) return std::string(6, ',');
  return fmt::format("{},{},{},{},{},{},{}", csv_field(outcome.score), outcome.achieved ? 1 : 0,
                     outcome.reached ? 1 : 0, outcome.modules, csv_field(outcome.mass), csv_field(outcome.goal_error),
                     outcome.bound ? csv_field(outcome.bound->score) : "");
}

std::string outcome_fields(const CellOutcome& outcome) {
  const Progress& spent = outcome.spent;
  return fmt::format("{},{},{},{},{},{},{},{},{}", design_fields(outcome), spent.evaluations, spent.program_evaluations,
                     spent.work.forward, spent.work.ik_iterations, spent.work.distances, spent.work.planner_states,
                     csv_field(spent.seconds), csv_field(outcome.cpu_seconds));
}

}  // namespace

std::string runs_csv(const StudyRecord& record) {
  std::string text =
      "cell,kind,problem,instance_seed,instance,solver,options,seed,training,timed,state,score,achieved,reached,"
      "modules,"
      "mass_kg,goal_error_m,bound,evaluations,program_evaluations,forward,ik_iterations,distances,planner_states,"
      "seconds,"
      "cpu_seconds,stop,failure\n";
  const std::string nothing(14, ',');
  for (const CellRecord& cell : record.cells) {
    if (cell.state == CellState::kStarted) continue;
    const CellKey& key = cell.key;
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", cell.id, name(key.kind), csv_field(key.problem),
                        instance_fields(key), csv_field(key.label), csv_field(key.solver), key.seed, key.training,
                        key.timed() ? 1 : 0, name(cell.state), cell.outcome ? outcome_fields(*cell.outcome) : nothing,
                        cell.outcome ? csv_field(cell.outcome->stop) : "", csv_field(cell.failure));
  }
  return text;
}

std::string traces_csv(const StudyRecord& record) {
  std::string text =
      "cell,problem,instance_seed,instance,solver,seed,evaluations,seconds,score,achieved,modules,mass_kg\n";
  for (const CellRecord& cell : record.cells) {
    const std::string run = fmt::format("{},{},{},{},{}", cell.id, csv_field(cell.key.problem),
                                        instance_fields(cell.key), csv_field(cell.key.label), cell.key.seed);
    for (const Improvement& point : cell.trace) {
      text += fmt::format("{},{},{},{},{},{},{}\n", run, point.evaluations, csv_field(point.seconds),
                          csv_field(point.score), point.achieved ? 1 : 0, point.modules, csv_field(point.mass));
    }
  }
  return text;
}

}  // namespace modsearch
