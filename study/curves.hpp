#pragma once

#include <modsearch/study/targets.hpp>
#include <vector>

namespace modsearch {

/// Share of (instance, seed, target) triples that a solver has met after so many evaluations or seconds, over all
/// `targets`: COCO's runtime distribution.
/// `training`: added to every runtime, to charge each run with what its policy cost to train (per instance); 0 charges
/// the use alone (amortised).
[[nodiscard]] StepFunction runtime_distribution(const StudyRuns& runs, std::size_t solver,
                                                const std::vector<Target>& targets, Measure measure,
                                                double training = 0.0);

/// Regret along the search: median over all runs of all instances with the quarters below and above.
struct Convergence {
  std::vector<double> spent;   ///< increasing, evenly spread on a logarithmic axis
  std::vector<double> low;     ///< lower quartile of regret; infinite while too few runs have achieved the task
  std::vector<double> median;  ///< of regret
  std::vector<double> high;    ///< upper quartile
};
/// At `points` amounts from the first improvement to the longest run. A run that has ended keeps its result.
[[nodiscard]] Convergence convergence(const StudyRuns& runs, std::size_t solver, Measure measure, int points = 60);

}  // namespace modsearch
