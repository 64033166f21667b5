#pragma once

#include <modsearch/study/break_even.hpp>
#include <modsearch/study/signed_rank.hpp>
#include <modsearch/study/targets.hpp>
#include <optional>
#include <vector>

namespace modsearch {

/// One solver in the table of a comparison.
struct SummaryRow {
  std::string label;
  bool trained = false;
  int runs = 0;
  int failed = 0;                          ///< of these: crashed, or threw
  Proportion achieved{};                   ///< share of the runs that achieved the task
  Estimate regret{};                       ///< interquartile mean over all runs of all instances; may be infinite
  std::vector<Proportion> success{};       ///< per target
  std::vector<double> evaluations{};       ///< expected runtime per target
  std::vector<double> seconds{};           ///< expected runtime per target [s]
  double median_evaluations = 0.0;         ///< of a whole run
  double median_seconds = 0.0;             ///< of a whole run [s]
  std::optional<TrainingCost> training{};  ///< of its policies
};

/// How two solvers compare, as the first sees it.
struct Comparison {
  std::size_t first = 0;  ///< indices into the rows
  std::size_t second = 0;
  Estimate improvement{};  ///< probability that a run of `first` has less regret than one of `second`
  SignedRank test{};       ///< of the pairs of regret, `second` minus `first`
  double p = 1.0;          ///< the test's, adjusted by Holm for all comparisons of the summary
};

/// Where a trained solver begins to pay against another one, at one target.
struct BreakEven {
  std::size_t trained = 0;  ///< indices into the rows
  std::size_t classical = 0;
  double tasks = 0.0;  ///< infinite: never
};

/// The tables of a comparison: a row per solver that has runs.
struct Summary {
  std::vector<Target> targets{};
  std::vector<SummaryRow> rows{};
  std::vector<Comparison> comparisons{};  ///< every pair of rows that share instances, once
  int instances = 0;                      ///< that have runs
  int optimal = 0;                        ///< of these: certified optimal
  int bounded = 0;                        ///< of these: with a bound, and a gap
  int unreachable = 0;                    ///< proved, and left out
  double largest_gap = 0.0;               ///< between bound and best known score
  bool paired_by_instance = true;         ///< what a pair of the tests is: an instance, or a seed of the only instance
};

/// Pairs of the tests are instances, each with the medians of its runs; where there is only one instance, its seeds.
/// Intervals come from `rng`.
[[nodiscard]] Summary summarise(const StudyRecord& record, const StudyRuns& runs, Rng rng,
                                BootstrapOptions options = {});

/// Of a row, to target number `target`; infinite where no run meets it.
[[nodiscard]] double expected_runtime(const SummaryRow& row, std::size_t target, Measure measure);

/// Cost of a solver at target number `target` in the measure given; nothing for one that was not trained.
[[nodiscard]] std::optional<AmortisedCost> amortised_cost(const SummaryRow& row, std::size_t target, Measure measure);

/// All pairs of a trained and another solver. Costs are expected runtimes to the target, so both are charged for the
/// runs that miss it: that is what "at equal quality" means here.
[[nodiscard]] std::vector<BreakEven> break_evens(const Summary& summary, std::size_t target, Measure measure);

/// The share of runs that have to meet a target for a comparison of costs to say something about a policy: an expected
/// runtime speaks of restarts, and a policy that misses a task misses it again.
constexpr double kComparable = 0.5;

/// Where a comparison of costs says most: the hardest target that some trained and some other solver meet in a
/// share kComparable of their runs, else the hardest that any solver so meets; 0 if there is none.
[[nodiscard]] std::size_t telling_target(const Summary& summary);

}  // namespace modsearch
