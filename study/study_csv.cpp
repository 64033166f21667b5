#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/study/study_csv.hpp>

namespace modsearch {
namespace {

// In quotes where it needs them (RFC 4180).
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string{"\"\""} : std::string{c};
  return quoted + '"';
}

// The shortest text that reads back as the same number; infinite ones as pandas and R read them.
std::string field(double number) {
  if (std::isfinite(number)) return fmt::format("{}", number);
  return std::isnan(number) ? "NaN" : number > 0.0 ? "Inf" : "-Inf";
}

std::string instance_fields(const CellKey& key) {
  return key.instance ? fmt::format("{},{}", key.instance->seed, key.instance->index) : std::string{","};
}

// What was found; a training finds no design.
std::string design_fields(const CellOutcome& outcome) {
  if (outcome.training) return std::string(6, ',');
  return fmt::format("{},{},{},{},{},{},{}", field(outcome.score), outcome.achieved ? 1 : 0, outcome.reached ? 1 : 0,
                     outcome.modules, field(outcome.mass), field(outcome.goal_error),
                     outcome.bound ? field(outcome.bound->score) : "");
}

std::string outcome_fields(const CellOutcome& outcome) {
  const Progress& spent = outcome.spent;
  return fmt::format("{},{},{},{},{},{},{},{},{}", design_fields(outcome), spent.evaluations, spent.program_evaluations,
                     spent.work.forward, spent.work.ik_iterations, spent.work.distances, spent.work.planner_states,
                     field(spent.seconds), field(outcome.cpu_seconds));
}

}  // namespace

std::string runs_csv(const StudyRecord& record) {
  std::string text =
      "cell,kind,problem,instance_seed,instance,solver,options,seed,training,timed,state,score,achieved,reached,modules,"
      "mass_kg,goal_error_m,bound,evaluations,program_evaluations,forward,ik_iterations,distances,planner_states,seconds,"
      "cpu_seconds,stop,failure\n";
  const std::string nothing(14, ',');
  for (const CellRecord& cell : record.cells) {
    if (cell.state == CellState::kStarted) continue;
    const CellKey& key = cell.key;
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", cell.id, name(key.kind), field(key.problem),
                        instance_fields(key), field(key.label), field(key.solver), key.seed, key.training,
                        key.timed() ? 1 : 0, name(cell.state), cell.outcome ? outcome_fields(*cell.outcome) : nothing,
                        cell.outcome ? field(cell.outcome->stop) : "", field(cell.failure));
  }
  return text;
}

std::string traces_csv(const StudyRecord& record) {
  std::string text = "cell,problem,instance_seed,instance,solver,seed,evaluations,seconds,score,achieved,modules,mass_kg\n";
  for (const CellRecord& cell : record.cells) {
    const std::string run = fmt::format("{},{},{},{},{}", cell.id, field(cell.key.problem), instance_fields(cell.key),
                                        field(cell.key.label), cell.key.seed);
    for (const Improvement& point : cell.trace) {
      text += fmt::format("{},{},{},{},{},{},{}\n", run, point.evaluations, field(point.seconds), field(point.score),
                          point.achieved ? 1 : 0, point.modules, field(point.mass));
    }
  }
  return text;
}

}  // namespace modsearch
