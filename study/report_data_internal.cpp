#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/study/curves.hpp>
#include <modsearch/study/report_data_internal.hpp>
#include <modsearch/study/summary.hpp>

namespace modsearch {
namespace {

using Json = nlohmann::json;

constexpr Measure kMeasures[] = {Measure::kEvaluations, Measure::kSeconds};

// Six digits are finer than a pixel, and short numbers keep the page small.
Json number(double value) {
  if (!std::isfinite(value) || value == 0.0) return std::isfinite(value) ? Json(0.0) : Json();
  const double scale = std::pow(10.0, 5 - std::floor(std::log10(std::abs(value))));
  return std::isfinite(scale) && scale > 0.0 ? Json(std::round(value * scale) / scale) : Json(value);
}

Json numbers(const std::vector<double>& values) {
  Json out = Json::array();
  for (const double value : values) out.push_back(number(value));
  return out;
}

Json json_of(const Proportion& share) { return {number(share.value), number(share.low), number(share.high)}; }
Json json_of(const Estimate& estimate) { return {number(estimate.value), number(estimate.low), number(estimate.high)}; }

// At most so many steps are drawn; of longer functions every k-th and the last.
constexpr std::size_t kMostSteps = 400;

Json json_of(const StepFunction& steps) {
  const std::size_t stride = (steps.at.size() + kMostSteps - 1) / kMostSteps;
  std::vector<double> at, value;
  for (std::size_t i = 0; i < steps.at.size(); ++i) {
    if (i % stride != 0 && i + 1 != steps.at.size()) continue;
    at.push_back(steps.at[i]);
    value.push_back(steps.value[i]);
  }
  return {{"x", numbers(at)}, {"y", numbers(value)}};
}

Json profiles_json(const StudyRuns& runs, const std::vector<Target>& targets, Measure measure, bool data) {
  Json out = Json::array();
  for (const Target& target : targets) {
    const PairedRuntimes paired = paired_runtimes(runs, target, measure);
    Json& of_target = out.emplace_back(Json::array());
    if (paired.dimensions.empty()) continue;
    for (const StepFunction& profile :
         data ? data_profiles(paired.runtimes, paired.dimensions) : performance_profiles(paired.runtimes)) {
      of_target.push_back(json_of(profile));
    }
  }
  return out;
}

Json curves_json(const StudyRecord& record, const StudyRuns& runs, const std::vector<Target>& targets,
                 Measure measure) {
  Json use = Json::array(), per_instance = Json::array(), converging = Json::array();
  for (std::size_t solver = 0; solver < runs.solvers.size(); ++solver) {
    const std::optional<TrainingCost> training = training_cost(record, runs, solver);
    const double cost = !training ? 0.0 : measure == Measure::kEvaluations ? training->evaluations : training->seconds;
    use.push_back(json_of(runtime_distribution(runs, solver, targets, measure)));
    per_instance.push_back(json_of(runtime_distribution(runs, solver, targets, measure, cost)));
    const Convergence curve = convergence(runs, solver, measure);
    converging.push_back({{"x", numbers(curve.spent)},
                          {"low", numbers(curve.low)},
                          {"y", numbers(curve.median)},
                          {"high", numbers(curve.high)}});
  }
  return {{"use", std::move(use)},
          {"perInstance", std::move(per_instance)},
          {"convergence", std::move(converging)},
          {"performance", profiles_json(runs, targets, measure, false)}};
}

Json row_json(const SummaryRow& row) {
  Json out{{"label", row.label},
           {"runs", row.runs},
           {"failed", row.failed},
           {"achieved", json_of(row.achieved)},
           {"regret", json_of(row.regret)},
           {"evaluations", numbers(row.evaluations)},
           {"seconds", numbers(row.seconds)},
           {"medianEvaluations", number(row.median_evaluations)},
           {"medianSeconds", number(row.median_seconds)}};
  for (const Proportion& share : row.success) out["success"].push_back(json_of(share));
  if (row.training) {
    out["training"] = {{"evaluations", number(row.training->evaluations)},
                       {"seconds", number(row.training->seconds)},
                       {"count", row.training->trainings}};
  }
  return out;
}

Json group_json(const StudyRecord& record, const std::string& problem, const Rng& rng, const ReportOptions& options) {
  const StudyRuns runs = runs_of(record, problem);
  const Summary summary = summarise(record, runs, rng.fork(problem), options.bootstrap);
  Json out{{"name", problem},
           {"instances", summary.instances},
           {"optimal", summary.optimal},
           {"bounded", summary.bounded},
           {"unreachable", summary.unreachable},
           {"largestGap", number(summary.largest_gap)},
           {"pairs", summary.paired_by_instance ? "instances" : "seeds"},
           {"target", telling_target(summary)},
           {"rows", Json::array()},
           {"comparisons", Json::array()},
           {"dataProfile", profiles_json(runs, summary.targets, Measure::kEvaluations, true)}};
  for (const SummaryRow& row : summary.rows) out["rows"].push_back(row_json(row));
  for (const Comparison& comparison : summary.comparisons) {
    out["comparisons"].push_back({{"first", comparison.first},
                                  {"second", comparison.second},
                                  {"improvement", json_of(comparison.improvement)},
                                  {"pairs", comparison.test.pairs},
                                  {"p", number(comparison.p)}});
  }
  for (const Measure measure : kMeasures) {
    const std::string key{name(measure)};
    out["curves"][key] = curves_json(record, runs, summary.targets, measure);
    Json& points = out["breakEven"][key] = Json::array();
    for (std::size_t target = 0; target < summary.targets.size(); ++target) {
      Json& of_target = points.emplace_back(Json::array());
      for (const BreakEven& point : break_evens(summary, target, measure)) {
        of_target.push_back(
            {{"trained", point.trained}, {"classical", point.classical}, {"tasks", number(point.tasks)}});
      }
    }
  }
  return out;
}

Json instance_json(const StudyRuns& runs, std::size_t index, const ViewLinks& views) {
  const InstanceFacts& facts = runs.instances[index];
  Json out{{"name", facts.name()},
           {"problem", facts.problem},
           {"certificate", name(facts.certainty())},
           {"bound", facts.bound ? number(*facts.bound) : Json()},
           {"regrets", Json::array()}};
  if (facts.best != nullptr) {
    const CellOutcome& outcome = *facts.best->outcome;
    out["best"] = {{"score", number(outcome.score)},
                   {"modules", outcome.modules},
                   {"mass", number(outcome.mass)},
                   {"solver", facts.best->key.label},
                   {"cell", facts.best->id}};
    // Of the whole numbers: both are shown with six digits, the difference would have none.
    if (facts.bound) out["gap"] = number(std::max(0.0, *facts.bound - outcome.score));
    if (const auto link = views.find(facts.best->id); link != views.end()) out["view"] = link->second;
  }
  for (std::size_t solver = 0; solver < runs.solvers.size(); ++solver) {
    std::vector<double> regrets;
    for (const CellRecord* run : runs.runs[solver][index]) regrets.push_back(regret(*run, facts));
    out["regrets"].push_back(regrets.empty() ? Json("none") : number(quantile(std::move(regrets), 0.5)));
  }
  return out;
}

Json study_json(const StudyRecord& record) {
  const StudyFacts& study = record.study;
  const auto count = [&](CellState state) {
    return std::count_if(record.cells.begin(), record.cells.end(),
                         [&](const CellRecord& cell) { return cell.state == state; });
  };
  const bool timed =
      std::any_of(record.cells.begin(), record.cells.end(), [](const CellRecord& cell) { return cell.key.timed(); });
  return {{"name", study.name},
          {"hash", study.hash},
          {"version", study.version},
          {"command", study.command},
          {"compiler", study.compiler},
          {"instructionSet", study.instruction_set},
          {"cells", study.n_cells},
          {"done", count(CellState::kDone)},
          {"failed", count(CellState::kFailed)},
          {"seeds", study.seeds.size()},
          {"evaluations", study.budget.evaluations},
          {"seconds", number(study.budget.seconds)},
          {"timed", timed}};
}

}  // namespace

Json report_data(const StudyRecord& record, const ViewLinks& views, const ReportOptions& options) {
  const Rng rng{options.seed};
  Json out{{"study", study_json(record)}, {"resamples", options.bootstrap.resamples},
           {"solvers", Json::array()},    {"targets", Json::array()},
           {"groups", Json::array()},     {"instances", Json::array()},
           {"failures", Json::array()}};
  for (const SolverFacts& solver : record.study.solvers) {
    out["solvers"].push_back({{"label", solver.label}, {"solver", solver.solver}, {"trained", solver.trained}});
  }
  for (const Target& target : targets_of(record.study)) out["targets"].push_back(target.name());
  if (record.study.problems.size() > 1) out["groups"].push_back(group_json(record, "", rng, options));
  for (const ProblemFacts& problem : record.study.problems) {
    out["groups"].push_back(group_json(record, problem.name, rng, options));
  }
  const StudyRuns runs = runs_of(record);
  for (std::size_t i = 0; i < runs.instances.size(); ++i) out["instances"].push_back(instance_json(runs, i, views));
  for (const CellRecord& cell : record.cells) {
    if (cell.state != CellState::kFailed) continue;
    const InstanceFacts where{.problem = cell.key.problem, .instance = cell.key.instance};
    out["failures"].push_back({{"cell", cell.id},
                               {"label", cell.key.label},
                               {"instance", where.name()},
                               {"seed", cell.key.seed},
                               {"what", cell.failure}});
  }
  return out;
}

}  // namespace modsearch
