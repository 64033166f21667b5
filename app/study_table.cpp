#include "app/study_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <modsearch/study/duration_text.hpp>
#include <modsearch/study/targets.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <vector>

namespace modsearch::app {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

// Half-way between the two in the middle of an even number; NaN of none.
double median(std::vector<double> values) {
  if (values.empty()) return kNothing;
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

nlohmann::ordered_json number_or_null(double number) {
  return std::isfinite(number) ? nlohmann::ordered_json(number) : nlohmann::ordered_json(nullptr);
}

struct Row {
  std::string label;
  int runs = 0;
  int achieved = 0;
  int failed = 0;
  std::map<std::string, int> failures{};  // of runs whose best is not achieved, by their reasons
  double score = kNothing;
  double regret = kNothing;
  double evaluations = kNothing;
  double seconds = kNothing;
  double training_seconds = kNothing;
};

Row row_of(const StudyRecord& record, const StudyRuns& runs, std::size_t solver) {
  Row row{.label = runs.solvers[solver].label};
  row.failed = runs.n_failed(solver);
  std::vector<double> scores, regrets, evaluations, seconds;
  for (std::size_t i = 0; i < runs.instances.size(); ++i) {
    for (const CellRecord* cell : runs.runs[solver][i]) {
      if (!cell->outcome) continue;
      ++row.runs;
      scores.push_back(cell->outcome->score);
      evaluations.push_back(static_cast<double>(cell->outcome->spent.evaluations));
      seconds.push_back(cell->outcome->spent.seconds);
      if (!cell->outcome->failure.empty()) ++row.failures[cell->outcome->failure];
      if (!cell->outcome->achieved) continue;
      ++row.achieved;
      regrets.push_back(regret(*cell, runs.instances[i]));
    }
  }
  row.score = median(std::move(scores));
  row.regret = median(std::move(regrets));
  row.evaluations = median(std::move(evaluations));
  row.seconds = median(std::move(seconds));
  if (const auto cost = training_cost(record, runs, solver)) row.training_seconds = cost->seconds;
  return row;
}

// The bounds of one problem: median over its instances, and how many there are.
Row bound_row(const StudyRecord& record, const std::string& problem) {
  Row row{.label = "certified bound"};
  std::vector<double> scores, seconds;
  for (const CellRecord& cell : record.cells) {
    if (cell.key.kind != CellKind::kBound || cell.key.problem != problem) continue;
    row.failed += cell.state == CellState::kFailed;
    if (!cell.outcome) continue;
    ++row.runs;
    seconds.push_back(cell.outcome->spent.seconds);
    if (!cell.outcome->bound || !std::isfinite(cell.outcome->bound->score)) continue;
    ++row.achieved;
    scores.push_back(cell.outcome->bound->score);
  }
  row.score = median(std::move(scores));
  row.seconds = median(std::move(seconds));
  return row;
}

std::vector<Row> rows_of(const StudyRecord& record, const StudyRuns& runs, const std::string& problem) {
  std::vector<Row> rows;
  for (std::size_t solver = 0; solver < runs.solvers.size(); ++solver) rows.push_back(row_of(record, runs, solver));
  if (const Row bound = bound_row(record, problem); bound.runs + bound.failed > 0) rows.push_back(bound);
  return rows;
}

// What the regret of a problem's runs is measured from.
std::string reference_of(const StudyRuns& runs) {
  std::size_t bounded = 0;
  for (const InstanceFacts& instance : runs.instances) bounded += instance.bound.has_value();
  if (bounded == 0) return "the best known score";
  if (bounded == runs.instances.size()) return "what is proved to be possible at most";
  return fmt::format("what is proved to be possible at most ({} of {} instances) or the best known score", bounded,
                     runs.instances.size());
}

std::string cell(double number, int digits) {
  return std::isfinite(number) ? fmt::format("{:.{}f}", number, digits) : std::string{"-"};
}

// What the first failed cell of each solver had to say.
std::string failed_text(const StudyRecord& record) {
  std::string text;
  std::set<std::string> told;
  for (const CellRecord& cell : record.cells) {
    if (cell.state != CellState::kFailed || !told.insert(cell.key.label).second) continue;
    text += fmt::format("\nfailed       {} of {} on {}: {}", name(cell.key.kind), cell.key.label, cell.key.problem,
                        cell.failure);
  }
  return text.empty() ? text : text + "\n";
}

std::string unfinished_text(const StudyRecord& record) {
  if (record.n_ended() >= record.study.n_cells) return "";
  return fmt::format("\nunfinished   {} of {} cells are done; --resume goes on\n", record.n_ended(),
                     record.study.n_cells);
}

// "   not achieved: 2 torque, 1 unreachable"; nothing where all are.
std::string failures_text(const Row& row) {
  std::string text;
  for (const auto& [reason, n] : row.failures) {
    text += fmt::format("{}{} {}", text.empty() ? "   not achieved: " : ", ", n, reason);
  }
  return text;
}

}  // namespace

nlohmann::ordered_json study_json(const StudyRecord& record) {
  nlohmann::ordered_json json;
  json["study"] = record.study.name;
  json["cells"] = record.study.n_cells;
  json["ended"] = record.n_ended();
  json["problems"] = nlohmann::ordered_json::array();
  for (const ProblemFacts& problem : record.study.problems) {
    nlohmann::ordered_json solvers = nlohmann::ordered_json::array();
    const StudyRuns runs = runs_of(record, problem.name);
    for (const Row& row : rows_of(record, runs, problem.name)) {
      solvers.push_back({{"solver", row.label},
                         {"runs", row.runs},
                         {"achieved", row.achieved},
                         {"failed", row.failed},
                         {"failures", row.failures},
                         {"medianScore", number_or_null(row.score)},
                         {"medianRegret", number_or_null(row.regret)},
                         {"medianEvaluations", number_or_null(row.evaluations)},
                         {"medianSeconds", number_or_null(row.seconds)},
                         {"trainingSeconds", number_or_null(row.training_seconds)}});
    }
    json["problems"].push_back({{"problem", problem.name}, {"solvers", std::move(solvers)}});
  }
  return json;
}

std::string study_text(const StudyRecord& record) {
  std::size_t width = 15;
  for (const SolverFacts& solver : record.study.solvers) width = std::max(width, solver.label.size());
  std::string text;
  for (const ProblemFacts& problem : record.study.problems) {
    const std::size_t n = std::max<std::size_t>(problem.instances.size(), 1);
    const StudyRuns runs = runs_of(record, problem.name);
    text += fmt::format("\n{}: {} instance{}, {} seed{}; medians, regret of achieved runs against {}\n", problem.name,
                        n, n == 1 ? "" : "s", record.study.seeds.size(), record.study.seeds.size() == 1 ? "" : "s",
                        reference_of(runs));
    text += fmt::format("{:<{}} {:>11} {:>10} {:>9} {:>12} {:>9} {:>13}\n", "solver", width, "achieved", "score",
                        "regret", "evaluations", "time", "training [s]");
    for (const Row& row : rows_of(record, runs, problem.name)) {
      text += fmt::format("{:<{}} {:>11} {:>10} {:>9} {:>12} {:>9} {:>13}{}{}\n", row.label, width,
                          fmt::format("{} of {}", row.achieved, row.runs), cell(row.score, 3), cell(row.regret, 3),
                          cell(row.evaluations, 0), std::isfinite(row.seconds) ? duration_text(row.seconds) : "-",
                          cell(row.training_seconds, 1), row.failed > 0 ? fmt::format("   {} failed", row.failed) : "",
                          failures_text(row));
    }
  }
  return text + failed_text(record) + unfinished_text(record);
}

}  // namespace modsearch::app
