#pragma once

#include <modsearch/study/records.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace modsearch {

/// How much is known about the best that an instance allows.
enum class Certainty {
  kOptimal,      ///< a design is known that scores what the bound allows, within kCertifiedShare
  kBounded,      ///< there is a bound, and a gap to it
  kUnreachable,  ///< proved: no design achieves the task
  kNone,         ///< no bound; what is best is the best of this study
};
/// "optimal", "bounded", "unreachable", "none".
[[nodiscard]] std::string_view name(Certainty certainty);

/// A design this close to the bound counts as optimal: the share of its mass that might still be saved, which is what
/// proofs are asked for on the reference scenarios, and a little for how that is rounded.
inline constexpr double kCertifiedShare = 1.01e-4;
/// The same for scorings without mass, times the larger of 1 and the bound's size.
inline constexpr double kCertifiedGap = 1e-6;

/// One problem, or one instance of a family, with the best that is known about it.
struct InstanceFacts {
  std::string problem;
  std::optional<Instance> instance{};
  const CellRecord* best = nullptr;  ///< the run with the best achieved design, the first of equals; null: none
  std::optional<double> bound{};     ///< certified: no achieved design scores more
  bool unreachable = false;          ///< proved

  /// "seed/random_wide 1:0", or the problem alone.
  [[nodiscard]] std::string name() const;
  [[nodiscard]] Certainty certainty() const;
  /// What regret is measured from: the bound where there is one (never below the best known score), else the best known
  /// score; nothing where neither is known.
  [[nodiscard]] std::optional<double> reference_score() const;
  /// Modules of the best design, the base included. Only where there is one.
  [[nodiscard]] int reference_modules() const;
  /// What a design with as many modules as the best would weigh if it scored the reference score [kg]: the mass of the
  /// best itself where there is no bound. Only where there is a best.
  [[nodiscard]] double reference_mass() const;
  /// Number of types and parameters of the best design: the dimension for data profiles. 1 where there is none.
  [[nodiscard]] int dimension() const;
};

/// The runs of a study, or of one of its problems, where statistics find them. Refers to the record, which must outlive
/// it. Runs that have not ended are left out; failed ones are there, and count as runs that achieved nothing. Instances
/// that are proved unreachable have no runs: there is nothing to compare.
struct StudyRuns {
  std::vector<SolverFacts> solvers{};
  std::vector<InstanceFacts> instances{};                           ///< in the study's order
  std::vector<std::vector<std::vector<const CellRecord*>>> runs{};  ///< [n_solvers][n_instances][n_runs], by seed

  [[nodiscard]] int n_runs(std::size_t solver) const;
  [[nodiscard]] int n_failed(std::size_t solver) const;
};

/// `problem`: its instances only; empty: those of all.
[[nodiscard]] StudyRuns runs_of(const StudyRecord& record, std::string_view problem = {});

/// What the policies behind a solver's runs cost to train: on average over the trainings on one family, summed over the
/// families, for whoever has tasks of all of them needs a policy for each.
struct TrainingCost {
  double evaluations = 0.0;
  double seconds = 0.0;  ///< of CPU time: a training is long enough to share its core with others
  int trainings = 0;     ///< how many there were
};
/// Null for a solver that is not trained, or whose trainings are not done.
[[nodiscard]] std::optional<TrainingCost> training_cost(const StudyRecord& record, const StudyRuns& runs,
                                                        std::size_t solver);

}  // namespace modsearch
