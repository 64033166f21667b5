#include "app/study_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
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

// Best possible or best known score of each instance.
class BestKnown {
 public:
  explicit BestKnown(const StudyRecord& record) {
    for (const CellRecord& cell : record.cells) {
      if (!cell.outcome || cell.outcome->training) continue;
      Known& known = known_[name_of(cell.key)];
      if (cell.outcome->bound) known.bound = std::min(known.bound, cell.outcome->bound->score);
      if (cell.outcome->achieved) known.score = std::max(known.score, cell.outcome->score);
    }
  }
  [[nodiscard]] double of(const CellKey& key) const {
    const Known& known = known_.at(name_of(key));
    return std::isfinite(known.bound) ? known.bound : known.score;
  }

 private:
  struct Known {
    double bound = std::numeric_limits<double>::infinity();
    double score = -std::numeric_limits<double>::infinity();
  };
  static std::string name_of(const CellKey& key) {
    return key.instance ? fmt::format("{} {}:{}", key.problem, key.instance->seed, key.instance->index) : key.problem;
  }
  std::map<std::string, Known> known_;
};

struct Row {
  std::string label;
  int runs = 0;
  int achieved = 0;
  int failed = 0;
  double score = kNothing;
  double regret = kNothing;
  double evaluations = kNothing;
  double seconds = kNothing;
  double training_seconds = kNothing;
};

Row row_of(const StudyRecord& record, const std::string& problem, const SolverFacts& solver, const BestKnown& best) {
  Row row{.label = solver.label};
  std::vector<double> scores, regrets, evaluations, seconds, training;
  for (const CellRecord& cell : record.cells) {
    if (cell.key.label != solver.label) continue;
    if (cell.key.kind == CellKind::kTraining && cell.outcome) training.push_back(cell.outcome->spent.seconds);
    if (cell.key.kind != CellKind::kRun || cell.key.problem != problem) continue;
    row.failed += cell.state == CellState::kFailed;
    if (!cell.outcome) continue;
    ++row.runs;
    scores.push_back(cell.outcome->score);
    evaluations.push_back(static_cast<double>(cell.outcome->spent.evaluations));
    seconds.push_back(cell.outcome->spent.seconds);
    if (!cell.outcome->achieved) continue;
    ++row.achieved;
    regrets.push_back(best.of(cell.key) - cell.outcome->score);
  }
  row.score = median(std::move(scores));
  row.regret = median(std::move(regrets));
  row.evaluations = median(std::move(evaluations));
  row.seconds = median(std::move(seconds));
  row.training_seconds = median(std::move(training));
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

std::vector<Row> rows_of(const StudyRecord& record, const std::string& problem) {
  const BestKnown best{record};
  std::vector<Row> rows;
  for (const SolverFacts& solver : record.study.solvers) rows.push_back(row_of(record, problem, solver, best));
  if (const Row bound = bound_row(record, problem); bound.runs + bound.failed > 0) rows.push_back(bound);
  return rows;
}

std::string cell(double number, int digits) {
  return std::isfinite(number) ? fmt::format("{:.{}f}", number, digits) : std::string{"-"};
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
    for (const Row& row : rows_of(record, problem.name)) {
      solvers.push_back({{"solver", row.label},
                         {"runs", row.runs},
                         {"achieved", row.achieved},
                         {"failed", row.failed},
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
    text += fmt::format("\n{}: {} instance{}, {} seed{}; medians, regret of the runs that achieved the task\n",
                        problem.name, n, n == 1 ? "" : "s", record.study.seeds.size(),
                        record.study.seeds.size() == 1 ? "" : "s");
    text += fmt::format("{:<{}} {:>11} {:>10} {:>9} {:>12} {:>9} {:>13}\n", "solver", width, "achieved", "score",
                        "regret", "evaluations", "seconds", "training [s]");
    for (const Row& row : rows_of(record, problem.name)) {
      text += fmt::format("{:<{}} {:>11} {:>10} {:>9} {:>12} {:>9} {:>13}{}\n", row.label, width,
                          fmt::format("{} of {}", row.achieved, row.runs), cell(row.score, 3), cell(row.regret, 3),
                          cell(row.evaluations, 0), cell(row.seconds, 4), cell(row.training_seconds, 1),
                          row.failed > 0 ? fmt::format("   {} failed", row.failed) : "");
    }
  }
  return text;
}

}  // namespace modsearch::app
