#pragma once

#include <modsearch/study/bootstrap.hpp>
#include <modsearch/study/profiles.hpp>
#include <modsearch/study/runtimes.hpp>
#include <modsearch/study/study_runs.hpp>
#include <string>
#include <vector>

namespace modsearch {

/// What a run is timed against; each one includes those before it.
struct Target {
  enum class Kind {
    kAchieved,       ///< a design that achieves the task
    kFewestModules,  ///< with no more modules than the best known one
    kMass,           ///< and with a mass within `percent` of the reference mass
  };
  Kind kind = Kind::kAchieved;
  double percent = 0.0;

  /// "achieved", "fewest modules", "mass within 5 %".
  [[nodiscard]] std::string name() const;
};

/// The targets of a study, from the easiest on.
[[nodiscard]] std::vector<Target> targets_of(const StudyFacts& study);

/// What runs are charged.
enum class Measure {
  kEvaluations,  ///< calls of the score
  kSeconds,      ///< wall clock
};
/// "evaluations", "seconds".
[[nodiscard]] std::string_view name(Measure measure);

/// How a run fared with a target: the first improvement that meets it, or all that the run spent. A failed run has
/// spent its budget, as far as that is finite.
[[nodiscard]] TargetRun target_run(const CellRecord& run, const InstanceFacts& instance, const Target& target,
                                   Measure measure);

/// Reference score minus the score of the run's result; infinite where the run achieved nothing, or where nothing is
/// known of the instance.
[[nodiscard]] double regret(const CellRecord& run, const InstanceFacts& instance);

/// The regret after `spent`; infinite before the first achieved design.
[[nodiscard]] double regret_after(const CellRecord& run, const InstanceFacts& instance, Measure measure, double spent);

/// How all runs of a solver fared with a target, instance by instance.
[[nodiscard]] std::vector<TargetRun> target_runs(const StudyRuns& runs, std::size_t solver, const Target& target,
                                                 Measure measure);

/// Final regrets of a solver, a stratum per instance that has runs.
[[nodiscard]] Strata regrets(const StudyRuns& runs, std::size_t solver);

/// Runtimes for profiles: one "problem" for each instance and seed that every solver has run.
struct PairedRuntimes {
  RuntimeTable runtimes{};        ///< [n_solvers x n_pairs]
  std::vector<int> dimensions{};  ///< [n_pairs]
};
[[nodiscard]] PairedRuntimes paired_runtimes(const StudyRuns& runs, const Target& target, Measure measure);

}  // namespace modsearch
