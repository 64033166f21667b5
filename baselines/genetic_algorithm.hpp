#pragma once

#include <modsearch/solvers/inner_solver.hpp>
#include <modsearch/solvers/search.hpp>

namespace modsearch {

/// Values called measured: best of those tried on ten instances of three scenarios each, drawn with seed 1000, by
/// evolution alone (docs/baselines.md).
struct GeneticOptions {
  int population = 60;  ///< designs that survive a generation, and children per generation; 30 to 120 differ little
  int tournament = 2;   ///< contestants for each parent; the least pressure there is, and 3 brings nothing (measured)
  double crossover = 0.5;  ///< share of children with two parents; 0.5 to 0.9 differ little (measured)
  double structure = 0.3;  ///< share of children whose sequence changes by one module; in the others lengths change
  double step = 0.5;       ///< largest step of a parameter, share of its interval; 0.1 in the source loses (measured)
  int precision = 10;      ///< smallest step: 2^-precision of the largest, 0.5 mm of a metre
  int polish = 2;          ///< designs polished by the smooth program per generation; 0: pure evolution
  Inner inner = Inner::kOwn;  ///< method of the polish: the fastest
};

/// A lexicographic genetic algorithm: designs compete for parenthood and survival by their rank
/// (baselines/lexicographic.hpp), so that expensive evaluations are spent on those that pass the cheap ones.
///
/// Source: Külz and Althoff 2024, "Optimizing Modular Robot Composition: A Lexicographic Genetic Algorithm Approach",
/// ICRA, arXiv:2309.08399: lexicographic fitness, fixed number of slots of which some are empty, crossover at one slot,
/// mutation by a module with fitting connectors or an empty slot. What parameters add: along the line through the
/// parents where both have a module of one type (extended line recombination), and mutation by steps of all magnitudes,
/// as likely one as the other (Muehlenbein and Schlierkamp-Voosen 1993, "Predictive models for the breeder genetic
/// algorithm", Evolutionary Computation 1(1), doi:10.1162/evco.1993.1.1.25): a ridge of a millimetre in a square metre
/// needs both ends of the scale.
///
/// Three things are ours. Empty slots stand at the end, so that equal places in two designs are equal places in the
/// arm. Designs of one length form a species: parents are drawn species by species and survivors in turn from each,
/// because a standing that one module more makes easy would otherwise crowd out the shorter designs that are worth
/// more. And bounds come first: designs whose types cannot beat the best are never evaluated.
class GeneticAlgorithm final : public SteppedSolver {
 public:
  /// Throws std::invalid_argument for an option out of range.
  explicit GeneticAlgorithm(GeneticOptions options = {});
  [[nodiscard]] std::string name() const override { return "ga"; }
  [[nodiscard]] const GeneticOptions& options() const { return options_; }
  [[nodiscard]] std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const override;

 private:
  GeneticOptions options_;
};

}  // namespace modsearch
