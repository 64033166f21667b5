#include <array>
#include <cmath>
#include <limits>
#include <modsearch/study/journal_json_internal.hpp>
#include <stdexcept>

namespace modsearch::detail {
namespace {

using nlohmann::ordered_json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();

// JSON has no infinite numbers.
ordered_json finite_or_null(double number) {
  return std::isfinite(number) ? ordered_json(number) : ordered_json(nullptr);
}

double number_or(const JsonCursor& cursor, double where_null) {
  return cursor.value().is_null() ? where_null : cursor.number();
}

ordered_json budget_json(const Budget& budget) {
  ordered_json json = ordered_json::object();
  if (budget.evaluations < kMost) json["evaluations"] = budget.evaluations;
  if (budget.seconds < kInfinity) json["seconds"] = budget.seconds;
  return json;
}

Budget read_budget(const JsonCursor& cursor) {
  cursor.expect_keys({"evaluations", "seconds"});
  Budget budget{.evaluations = kMost};
  if (const auto evaluations = cursor.find("evaluations")) budget.evaluations = evaluations->integer(0, kMost);
  budget.seconds = cursor.number_or("seconds", kInfinity, {.lower = 0.0});
  return budget;
}

ordered_json instance_json(const Instance& instance) { return {{"seed", instance.seed}, {"index", instance.index}}; }

Instance read_instance(const JsonCursor& cursor) {
  cursor.expect_keys({"seed", "index"});
  return {cursor.at("seed").unsigned_integer(), cursor.at("index").unsigned_integer()};
}

// Work has the same counters everywhere; one list of them.
template <typename AnyWork, typename Do>
void for_each_counter(AnyWork& work, Do&& act) {
  act("forward", work.forward);
  act("ikIterations", work.ik_iterations);
  act("distances", work.distances);
  act("plannerStates", work.planner_states);
}

ordered_json design_json(const DesignRecord& design) {
  ordered_json list = ordered_json::array();
  for (const DesignRecord::Module& module : design.modules) {
    ordered_json parameters = ordered_json::object();
    for (const auto& [name, value] : module.parameters) parameters[name] = value;
    list.push_back({{"type", module.type}, {"parameters", std::move(parameters)}});
  }
  return list;
}

DesignRecord read_design(const JsonCursor& cursor) {
  DesignRecord design;
  for (const JsonCursor& item : cursor.items()) {
    item.expect_keys({"type", "parameters"});
    DesignRecord::Module& module = design.modules.emplace_back();
    module.type = item.at("type").text();
    for (const auto& [name, value] : item.at("parameters").members()) module.parameters.emplace(name, value.number());
  }
  return design;
}

ordered_json postures_json(const Eigen::MatrixXd& postures) {
  ordered_json rows = ordered_json::array();
  for (const auto& row : postures.rowwise()) rows.push_back(std::vector<double>(row.begin(), row.end()));
  return rows;
}

Eigen::MatrixXd read_postures(const JsonCursor& cursor) {
  std::vector<std::vector<double>> rows;
  for (const JsonCursor& row : cursor.items()) {
    rows.emplace_back();
    for (const JsonCursor& number : row.items()) rows.back().push_back(number.number());
    if (rows.back().size() != rows.front().size()) row.fail("is not as long as the first row");
  }
  const auto n_joints = static_cast<Eigen::Index>(rows.empty() ? 0 : rows.front().size());
  Eigen::MatrixXd postures(static_cast<Eigen::Index>(rows.size()), n_joints);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    postures.row(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::RowVectorXd>(rows[i].data(), n_joints);
  }
  return postures;
}

ordered_json outcome_json(const CellOutcome& outcome) {
  ordered_json json;
  if (outcome.training) {
    const TrainingFacts& facts = *outcome.training;
    json["episodes"] = facts.episodes;
    json["steps"] = facts.steps;
    json["updates"] = facts.updates;
    json["meanReturn"] = finite_or_null(facts.mean_return);
    json["policy"] = facts.policy;
    json["weights"] = facts.weights;
  } else {
    json["design"] = design_json(outcome.design);
    if (!outcome.witness.empty()) json["postures"] = postures_json(outcome.witness.postures);
    json["score"] = finite_or_null(outcome.score);
    json["achieved"] = outcome.achieved;
    json["reached"] = outcome.reached;
    if (!outcome.failure.empty()) json["failure"] = outcome.failure;
    json["goalError_m"] = finite_or_null(outcome.goal_error);
    json["modules"] = outcome.modules;
    json["mass_kg"] = outcome.mass;
    json["terms"] = ordered_json::array();
    for (const TermRecord& term : outcome.terms) json["terms"].push_back({{"name", term.name}, {"value", term.value}});
  }
  if (outcome.bound) {
    json["bound"] = {{"score", finite_or_null(outcome.bound->score)}, {"reason", outcome.bound->reason}};
  }
  json["evaluations"] = outcome.spent.evaluations;
  json["failedEvaluations"] = outcome.spent.failed;
  json["programEvaluations"] = outcome.spent.program_evaluations;
  ordered_json work;
  for_each_counter(outcome.spent.work, [&](const char* key, std::int64_t count) { work[key] = count; });
  json["work"] = std::move(work);
  json["stop"] = outcome.stop;
  json["reason"] = outcome.reason;
  json["seconds"] = outcome.spent.seconds;
  json["cpuSeconds"] = outcome.cpu_seconds;
  return json;
}

ordered_json improvement_json(const Improvement& improvement) {
  return {{"evaluations", improvement.evaluations},
          {"seconds", improvement.seconds},
          {"score", finite_or_null(improvement.score)},
          {"achieved", improvement.achieved},
          {"modules", improvement.modules},
          {"mass_kg", improvement.mass}};
}

ordered_json event_line(const std::string& cell, const char* event, const ordered_json& rest) {
  ordered_json json{{"cell", cell}, {"event", event}};
  json.update(rest);
  return json;
}

std::int64_t count(const JsonCursor& line, const std::string& key) { return line.at(key).integer(0, kMost); }

TrainingFacts read_training(const JsonCursor& line) {
  return {.episodes = count(line, "episodes"),
          .steps = count(line, "steps"),
          .updates = count(line, "updates"),
          .mean_return = number_or(line.at("meanReturn"), -kInfinity),
          .policy = line.at("policy").text(),
          .weights = line.at("weights").text()};
}

constexpr std::array kKinds{CellKind::kTraining, CellKind::kBound, CellKind::kRun};

ordered_json improve_line(const std::string& cell, const Improvement& improvement) {
  return event_line(cell, "improve", improvement_json(improvement));
}

Improvement read_improvement(const JsonCursor& line) {
  line.expect_keys({"cell", "event", "evaluations", "seconds", "score", "achieved", "modules", "mass_kg"});
  return {.evaluations = count(line, "evaluations"),
          .seconds = line.at("seconds").number(),
          .score = number_or(line.at("score"), -kInfinity),
          .achieved = line.at("achieved").boolean(),
          .modules = static_cast<int>(line.at("modules").integer(1, 64)),
          .mass = line.at("mass_kg").number()};
}

ordered_json done_line(const std::string& cell, const CellOutcome& outcome) {
  return event_line(cell, "done", outcome_json(outcome));
}

CellOutcome read_outcome(const JsonCursor& line) {
  line.expect_keys({"cell",
                    "event",
                    "design",
                    "postures",
                    "score",
                    "achieved",
                    "reached",
                    "failure",
                    "goalError_m",
                    "modules",
                    "mass_kg",
                    "terms",
                    "bound",
                    "evaluations",
                    "failedEvaluations",
                    "programEvaluations",
                    "work",
                    "stop",
                    "reason",
                    "seconds",
                    "cpuSeconds",
                    "episodes",
                    "steps",
                    "updates",
                    "meanReturn",
                    "policy",
                    "weights"});
  CellOutcome outcome;
  if (line.has("policy")) {
    outcome.training = read_training(line);
  } else {
    outcome.design = read_design(line.at("design"));
    if (const auto postures = line.find("postures")) outcome.witness.postures = read_postures(*postures);
    outcome.score = number_or(line.at("score"), -kInfinity);
    outcome.achieved = line.at("achieved").boolean();
    outcome.reached = line.at("reached").boolean();
    outcome.failure = line.text_or("failure", "");
    outcome.goal_error = number_or(line.at("goalError_m"), kInfinity);
    outcome.modules = static_cast<int>(line.at("modules").integer(1, 64));
    outcome.mass = line.at("mass_kg").number();
    for (const JsonCursor& term : line.at("terms").items()) {
      term.expect_keys({"name", "value"});
      outcome.terms.push_back({term.at("name").text(), term.at("value").number()});
    }
  }
  if (const auto bound = line.find("bound")) {
    bound->expect_keys({"score", "reason"});
    outcome.bound = Bound{number_or(bound->at("score"), kInfinity), bound->at("reason").text()};
  }
  outcome.spent.evaluations = count(line, "evaluations");
  outcome.spent.failed = count(line, "failedEvaluations");
  outcome.spent.program_evaluations = count(line, "programEvaluations");
  const JsonCursor work = line.at("work");
  work.expect_keys({"forward", "ikIterations", "distances", "plannerStates"});
  for_each_counter(outcome.spent.work, [&](const char* key, std::int64_t& counter) { counter = count(work, key); });
  outcome.stop = line.at("stop").text();
  outcome.reason = line.at("reason").text();
  outcome.spent.seconds = line.at("seconds").number();
  outcome.cpu_seconds = line.at("cpuSeconds").number();
  return outcome;
}

ordered_json failed_line(const CellRecord& cell) {
  ordered_json json{{"what", cell.failure}};
  if (cell.signal) json["signal"] = *cell.signal;
  return event_line(cell.id, "failed", json);
}

void read_failure(const JsonCursor& line, CellRecord& cell) {
  line.expect_keys({"cell", "event", "what", "signal"});
  cell.failure = line.at("what").text();
  if (const auto signal = line.find("signal")) cell.signal = static_cast<int>(signal->integer(1, 128));
}

}  // namespace

ordered_json header_line(const StudyFacts& study) {
  ordered_json json{{"cell", nullptr}, {"event", "study"}, {"modsearch", 1}};
  json["name"] = study.name;
  json["hash"] = study.hash;
  json["version"] = study.version;
  json["command"] = study.command;
  json["compiler"] = study.compiler;
  json["instructionSet"] = study.instruction_set;
  json["cells"] = study.n_cells;
  json["problems"] = ordered_json::array();
  for (const ProblemFacts& problem : study.problems) {
    ordered_json instances = ordered_json::array();
    for (const Instance& instance : problem.instances) instances.push_back(instance_json(instance));
    json["problems"].push_back(
        {{"name", problem.name}, {"location", problem.location}, {"instances", std::move(instances)}});
  }
  json["solvers"] = ordered_json::array();
  for (const SolverFacts& solver : study.solvers) {
    json["solvers"].push_back({{"label", solver.label}, {"solver", solver.solver}, {"trained", solver.trained}});
  }
  json["seeds"] = study.seeds;
  json["budget"] = budget_json(study.budget);
  json["targets"] = {{"mass", study.mass_targets}};
  return json;
}

StudyFacts read_header(const JsonCursor& line) {
  line.expect_keys({"cell", "event", "modsearch", "name", "hash", "version", "command", "compiler", "instructionSet",
                    "cells", "problems", "solvers", "seeds", "budget", "targets"});
  if (line.at("event").text() != "study") line.at("event").fail_value("\"study\": a journal begins with its study");
  static_cast<void>(line.at("modsearch").integer(1, 1));
  StudyFacts study;
  study.name = line.at("name").text();
  study.hash = line.at("hash").text();
  study.version = line.at("version").text();
  study.command = line.at("command").text();
  study.compiler = line.at("compiler").text();
  study.instruction_set = line.at("instructionSet").text();
  study.n_cells = count(line, "cells");
  for (const JsonCursor& problem : line.at("problems").items()) {
    problem.expect_keys({"name", "location", "instances"});
    ProblemFacts& facts = study.problems.emplace_back();
    facts.name = problem.at("name").text();
    facts.location = problem.at("location").text();
    for (const JsonCursor& instance : problem.at("instances").items())
      facts.instances.push_back(read_instance(instance));
  }
  for (const JsonCursor& solver : line.at("solvers").items()) {
    solver.expect_keys({"label", "solver", "trained"});
    study.solvers.push_back({solver.at("label").text(), solver.at("solver").text(), solver.at("trained").boolean()});
  }
  for (const JsonCursor& seed : line.at("seeds").items()) study.seeds.push_back(seed.unsigned_integer());
  study.budget = read_budget(line.at("budget"));
  const JsonCursor targets = line.at("targets");
  targets.expect_keys({"mass"});
  for (const JsonCursor& share : targets.at("mass").items()) study.mass_targets.push_back(share.number());
  return study;
}

ordered_json start_line(const CellRecord& cell) {
  ordered_json json{{"number", cell.number}, {"kind", name(cell.key.kind)}, {"problem", cell.key.problem}};
  if (cell.key.instance) json["instance"] = instance_json(*cell.key.instance);
  json["label"] = cell.key.label;
  json["solver"] = cell.key.solver;
  json["seed"] = cell.key.seed;
  json["budget"] = budget_json(cell.key.budget);
  json["timed"] = cell.key.timed();
  if (!cell.key.training.empty()) json["training"] = cell.key.training;
  return event_line(cell.id, "start", json);
}

CellRecord read_start(const JsonCursor& line) {
  line.expect_keys({"cell", "event", "number", "kind", "problem", "instance", "label", "solver", "seed", "budget",
                    "timed", "training"});
  CellRecord cell;
  cell.id = line.at("cell").text();
  cell.number = count(line, "number");
  cell.key.kind = kKinds[line.at("kind").choice({"training", "bound", "run"})];
  cell.key.problem = line.at("problem").text();
  if (const auto instance = line.find("instance")) cell.key.instance = read_instance(*instance);
  cell.key.label = line.at("label").text();
  cell.key.solver = line.at("solver").text();
  cell.key.seed = line.at("seed").unsigned_integer();
  cell.key.budget = read_budget(line.at("budget"));
  cell.key.training = line.text_or("training", "");
  if (line.at("timed").boolean() != cell.key.timed()) line.at("timed").fail_value("what the budget says");
  return cell;
}

std::string ending_lines(const CellRecord& cell) {
  switch (cell.state) {
    case CellState::kStarted:
      throw std::invalid_argument("journal: cell " + cell.id + " has not ended");
    case CellState::kFailed:
      return to_line(failed_line(cell));
    case CellState::kDone:
      break;
  }
  std::string lines;
  for (const Improvement& improvement : cell.trace) lines += to_line(improve_line(cell.id, improvement));
  return lines + to_line(done_line(cell.id, cell.outcome.value()));
}

void read_ending(const JsonCursor& line, CellRecord& cell) {
  switch (line.at("event").choice({"improve", "done", "failed"})) {
    case 0:
      cell.trace.push_back(read_improvement(line));
      break;
    case 1:
      cell.outcome = read_outcome(line);
      cell.state = CellState::kDone;
      break;
    default:
      read_failure(line, cell);
      cell.state = CellState::kFailed;
  }
}

std::string to_line(const ordered_json& json) {
  // What solvers say in words need not be UTF-8.
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

ordered_json results(const CellRecord& cell) {
  ordered_json json = outcome_json(cell.outcome.value());
  json.erase("seconds");
  json.erase("cpuSeconds");
  json["trace"] = ordered_json::array();
  for (const Improvement& improvement : cell.trace) {
    json["trace"].push_back(improvement_json(improvement));
    json["trace"].back().erase("seconds");
  }
  return json;
}

}  // namespace modsearch::detail
