#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <modsearch/study/duration_text.hpp>
#include <modsearch/study/summary.hpp>
#include <modsearch/study/summary_markdown.hpp>
#include <optional>
#include <string_view>
#include <vector>

namespace modsearch {
namespace {

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : std::string{"∞"}; }

// 1234, not 1.23e+03.
std::string count(double value) {
  return std::isfinite(value) && value >= 100.0 ? fmt::format("{:.0f}", value) : number(value);
}

// A label as a cell of a table.
std::string cell_text(std::string_view label) {
  std::string text;
  for (const char c : label) {
    if (c == '|') text += '\\';
    text += c;
  }
  return text;
}

std::string percent(const Proportion& share) { return fmt::format("{:.0f} %", 100.0 * share.value); }

// Indices of the targets that the table shows.
std::vector<std::size_t> shown(const std::vector<Target>& targets) {
  std::vector<std::size_t> wanted, all;
  for (std::size_t t = 0; t < targets.size(); ++t) {
    if (targets[t].kind != Target::Kind::kMass) continue;
    all.push_back(t);
    if (targets[t].percent == 10.0 || targets[t].percent == 1.0) wanted.push_back(t);
  }
  return wanted.empty() ? all : wanted;
}

std::string row_text(const SummaryRow& row, const std::vector<std::size_t>& targets) {
  std::string text = fmt::format("| {} | {} | {} [{}, {}] |", cell_text(row.label), percent(row.achieved),
                                 number(row.regret.value), number(row.regret.low), number(row.regret.high));
  for (const std::size_t t : targets) {
    text += fmt::format(" {} | {} | {} |", percent(row.success[t]), count(row.evaluations[t]),
                        duration_text(row.seconds[t]));
  }
  text += fmt::format(" {} | {} |", count(row.median_evaluations), duration_text(row.median_seconds));
  text += row.training ? fmt::format(" {} |\n", duration_text(row.training->seconds)) : std::string{" |\n"};
  return text;
}

// The solver without training that meets a target at the least cost; nothing where none does.
std::optional<std::size_t> cheapest(const Summary& summary, std::size_t target, Measure measure) {
  std::optional<std::size_t> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t r = 0; r < summary.rows.size(); ++r) {
    const double cost = expected_runtime(summary.rows[r], target, measure);
    if (summary.rows[r].trained || !(cost < least)) continue;
    least = cost;
    best = r;
  }
  return best;
}

// "24 tasks, against ga (59)": from which on the trained solver costs less than the cheapest other one.
std::string pays(const Summary& summary, const AmortisedCost& trained, std::size_t target, Measure measure) {
  const std::optional<std::size_t> other = cheapest(summary, target, measure);
  if (!other) return "nothing else meets it";
  const SummaryRow& row = summary.rows[*other];
  const double cost = expected_runtime(row, target, measure);
  const double tasks = break_even_tasks(trained, cost);
  return fmt::format("{}, against {} ({})",
                     std::isfinite(tasks) ? fmt::format("{:.0f} tasks", std::ceil(tasks)) : "never",
                     cell_text(row.label), measure == Measure::kSeconds ? duration_text(cost) : count(cost));
}

// Where learning begins to pay, for each trained solver at the least number of modules and at each target shown that it
// meets in half of its runs: an expected runtime speaks of restarts, and a policy that misses a target misses it again.
std::string break_even_text(const Summary& summary, std::vector<std::size_t> targets) {
  for (std::size_t t = 0; t < summary.targets.size(); ++t) {
    if (summary.targets[t].kind == Target::Kind::kFewestModules) targets.insert(targets.begin(), t);
  }
  constexpr std::array kTasks = {1, 10, 100, 1000};
  std::string text;
  std::vector<std::string> missed;
  for (std::size_t r = 0; r < summary.rows.size(); ++r) {
    for (const std::size_t t : targets) {
      if (summary.rows[r].trained && summary.rows[r].success[t].value < kComparable) {
        missed.push_back(fmt::format("{} ({}, {})", cell_text(summary.rows[r].label), summary.targets[t].name(),
                                     percent(summary.rows[r].success[t])));
        break;  // what follows includes it
      }
      const std::optional<AmortisedCost> evaluations = amortised_cost(summary.rows[r], t, Measure::kEvaluations);
      const std::optional<AmortisedCost> seconds = amortised_cost(summary.rows[r], t, Measure::kSeconds);
      if (!evaluations || !seconds) continue;
      text += fmt::format("| {} | {} | {} | {} | {} | {} |", cell_text(summary.rows[r].label),
                          summary.targets[t].name(), percent(summary.rows[r].success[t]), count(evaluations->use),
                          pays(summary, *evaluations, t, Measure::kEvaluations),
                          pays(summary, *seconds, t, Measure::kSeconds));
      for (const int tasks : kTasks) text += fmt::format(" {} |", duration_text(seconds->per_task(tasks)));
      text += "\n";
    }
  }
  const std::string rest =
      missed.empty() ? ""
                     : fmt::format("\nMet in less than half of the runs, and not compared from there on: {}.\n",
                                   fmt::join(missed, "; "));
  if (text.empty()) return rest;
  std::string head = "| trained | target | met in | evaluations of a use | pays from, by evaluations | by time |";
  std::string rule = "|---|---|---|---|---|---|";
  for (const int tasks : kTasks) {
    head += fmt::format(" time per task, {} task{} |", tasks, tasks == 1 ? "" : "s");
    rule += "---|";
  }
  return fmt::format("\n{}\n{}\n{}{}", head, rule, text, rest);
}

std::string reference_text(const Summary& summary) {
  std::string text = fmt::format("{} instance{}", summary.instances, summary.instances == 1 ? "" : "s");
  text += fmt::format(": {} with a certified optimum, {} with a certified bound", summary.optimal, summary.bounded);
  if (summary.bounded > 0) text += fmt::format(" (gap up to {} points)", number(summary.largest_gap));
  if (summary.unreachable > 0) text += fmt::format(", {} more proved unreachable", summary.unreachable);
  return text + ". Regret is measured from the bound where there is one, else from the best known score.\n";
}

}  // namespace

std::string summary_markdown(const StudyRecord& record) {
  std::string text;
  if (record.n_ended() < record.study.n_cells) {
    text += fmt::format("Unfinished: {} of {} cells are done.\n\n", record.n_ended(), record.study.n_cells);
  }
  for (const ProblemFacts& problem : record.study.problems) {
    const StudyRuns runs = runs_of(record, problem.name);
    const Summary summary = summarise(record, runs, Rng{0});
    const std::vector<std::size_t> targets = shown(summary.targets);
    text += fmt::format("### {}\n\n| solver | achieved | regret |", problem.name);
    std::string rule = "|---|---|---|";
    for (const std::size_t t : targets) {
      text += fmt::format(" {}: runs | evaluations | time |", summary.targets[t].name());
      rule += "---|---|---|";
    }
    text += " evaluations of a run | time | training |\n" + rule + "---|---|---|\n";
    for (const SummaryRow& row : summary.rows) text += row_text(row, targets);
    text += break_even_text(summary, targets);
    text += fmt::format("\n{}\n", reference_text(summary));
  }
  return text;
}

}  // namespace modsearch
