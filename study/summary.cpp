#include <algorithm>
#include <cmath>
#include <modsearch/study/distribution.hpp>
#include <modsearch/study/summary.hpp>

namespace modsearch {
namespace {

double median_spent(const std::vector<std::vector<const CellRecord*>>& runs, Measure measure) {
  std::vector<double> spent;
  for (const auto& of_instance : runs) {
    for (const CellRecord* run : of_instance) {
      if (!run->outcome) continue;
      const Progress& progress = run->outcome->spent;
      spent.push_back(measure == Measure::kEvaluations ? static_cast<double>(progress.evaluations) : progress.seconds);
    }
  }
  return spent.empty() ? NAN : quantile(std::move(spent), 0.5);
}

SummaryRow row_of(const StudyRecord& record, const StudyRuns& runs, std::size_t solver,
                  const std::vector<Target>& targets, const Rng& rng, const BootstrapOptions& options) {
  SummaryRow row{.label = runs.solvers[solver].label,
                 .trained = runs.solvers[solver].trained,
                 .runs = runs.n_runs(solver),
                 .failed = runs.n_failed(solver)};
  row.regret = interquartile_mean(regrets(runs, solver), rng.fork(row.label), options);
  for (const Target& target : targets) {
    const std::vector<TargetRun> timed = target_runs(runs, solver, target, Measure::kEvaluations);
    const auto met = std::count_if(timed.begin(), timed.end(), [](const TargetRun& run) { return run.met; });
    row.success.push_back(success_rate(static_cast<int>(met), row.runs));
    row.evaluations.push_back(expected_runtime(timed));
    row.seconds.push_back(expected_runtime(target_runs(runs, solver, target, Measure::kSeconds)));
  }
  row.achieved = row.success.front();
  row.median_evaluations = median_spent(runs.runs[solver], Measure::kEvaluations);
  row.median_seconds = median_spent(runs.runs[solver], Measure::kSeconds);
  row.training = training_cost(record, runs, solver);
  return row;
}

// Final regrets of two solvers on the instances that both have run.
struct SharedRegrets {
  Strata first;
  Strata second;
};

SharedRegrets shared_regrets(const StudyRuns& runs, std::size_t first, std::size_t second) {
  SharedRegrets out;
  for (std::size_t i = 0; i < runs.instances.size(); ++i) {
    if (runs.runs[first][i].empty() || runs.runs[second][i].empty()) continue;
    for (auto [solver, strata] : {std::pair{first, &out.first}, std::pair{second, &out.second}}) {
      std::vector<double>& of_instance = strata->emplace_back();
      for (const CellRecord* run : runs.runs[solver][i]) of_instance.push_back(regret(*run, runs.instances[i]));
    }
  }
  return out;
}

// Infinite regrets of both sides are equal.
double difference(double a, double b) { return a == b ? 0.0 : a - b; }

SignedRank paired_test(const SharedRegrets& shared) {
  std::vector<double> differences;
  if (shared.first.size() > 1) {
    for (std::size_t i = 0; i < shared.first.size(); ++i) {
      differences.push_back(difference(quantile(shared.second[i], 0.5), quantile(shared.first[i], 0.5)));
    }
  } else {
    const std::size_t pairs = std::min(shared.first[0].size(), shared.second[0].size());
    for (std::size_t i = 0; i < pairs; ++i) differences.push_back(difference(shared.second[0][i], shared.first[0][i]));
  }
  return signed_rank_test(differences);
}

Strata negated(Strata strata) {
  for (std::vector<double>& values : strata) {
    for (double& value : values) value = -value;
  }
  return strata;
}

void compare_all(Summary& summary, const StudyRuns& runs, const std::vector<std::size_t>& solvers, const Rng& rng,
                 const BootstrapOptions& options) {
  for (std::size_t a = 0; a < solvers.size(); ++a) {
    for (std::size_t b = a + 1; b < solvers.size(); ++b) {
      const SharedRegrets shared = shared_regrets(runs, solvers[a], solvers[b]);
      if (shared.first.empty()) continue;
      const Rng own = rng.fork(summary.rows[a].label).fork(summary.rows[b].label);
      // Less regret is better, so that its negative is compared.
      summary.comparisons.push_back(
          {.first = a,
           .second = b,
           .improvement = probability_of_improvement(negated(shared.first), negated(shared.second), own, options),
           .test = paired_test(shared)});
    }
  }
  std::vector<double> p;
  for (const Comparison& comparison : summary.comparisons) p.push_back(comparison.test.p);
  const std::vector<double> adjusted = holm_adjusted(p);
  for (std::size_t i = 0; i < adjusted.size(); ++i) summary.comparisons[i].p = adjusted[i];
}

void count_certificates(Summary& summary, const StudyRuns& runs) {
  for (std::size_t i = 0; i < runs.instances.size(); ++i) {
    const InstanceFacts& facts = runs.instances[i];
    const Certainty certainty = facts.certainty();
    summary.unreachable += certainty == Certainty::kUnreachable;
    const bool has_runs =
        std::any_of(runs.runs.begin(), runs.runs.end(), [&](const auto& of_solver) { return !of_solver[i].empty(); });
    if (!has_runs) continue;
    ++summary.instances;
    summary.optimal += certainty == Certainty::kOptimal;
    if (certainty != Certainty::kBounded) continue;
    ++summary.bounded;
    const double gap = facts.best == nullptr ? INFINITY : *facts.bound - facts.best->outcome->score;
    summary.largest_gap = std::max(summary.largest_gap, gap);
  }
  summary.paired_by_instance = summary.instances > 1;
}

}  // namespace

Summary summarise(const StudyRecord& record, const StudyRuns& runs, Rng rng, BootstrapOptions options) {
  Summary out{.targets = targets_of(record.study)};
  std::vector<std::size_t> solvers;  // of the rows
  for (std::size_t solver = 0; solver < runs.solvers.size(); ++solver) {
    if (runs.n_runs(solver) == 0) continue;
    solvers.push_back(solver);
    out.rows.push_back(row_of(record, runs, solver, out.targets, rng, options));
  }
  compare_all(out, runs, solvers, rng, options);
  count_certificates(out, runs);
  return out;
}

double expected_runtime(const SummaryRow& row, std::size_t target, Measure measure) {
  return measure == Measure::kEvaluations ? row.evaluations[target] : row.seconds[target];
}

std::optional<AmortisedCost> amortised_cost(const SummaryRow& row, std::size_t target, Measure measure) {
  if (!row.training) return std::nullopt;
  return AmortisedCost{measure == Measure::kEvaluations ? row.training->evaluations : row.training->seconds,
                       expected_runtime(row, target, measure)};
}

std::vector<BreakEven> break_evens(const Summary& summary, std::size_t target, Measure measure) {
  std::vector<BreakEven> out;
  for (std::size_t t = 0; t < summary.rows.size(); ++t) {
    const std::optional<AmortisedCost> cost = amortised_cost(summary.rows[t], target, measure);
    if (!cost) continue;
    for (std::size_t c = 0; c < summary.rows.size(); ++c) {
      if (summary.rows[c].trained) continue;
      const double classical = expected_runtime(summary.rows[c], target, measure);
      out.push_back({.trained = t, .classical = c, .tasks = break_even_tasks(*cost, classical)});
    }
  }
  return out;
}

std::size_t telling_target(const Summary& summary) {
  const auto met = [&](std::size_t target, bool trained) {
    return std::any_of(summary.rows.begin(), summary.rows.end(), [&](const SummaryRow& row) {
      return row.trained == trained && row.success[target].value >= kComparable;
    });
  };
  for (std::size_t t = summary.targets.size(); t-- > 0;) {
    if (met(t, true) && met(t, false)) return t;
  }
  for (std::size_t t = summary.targets.size(); t-- > 0;) {
    if (met(t, true) || met(t, false)) return t;
  }
  return 0;
}

}  // namespace modsearch
