#pragma once

#include <modsearch/solvers/search.hpp>

namespace modsearch {

/// Defaults measured on ten instances of three scenarios each, drawn with seed 1000 (docs/baselines.md).
struct AnnealingOptions {
  int cycle = 500;     ///< evaluations from hot to cold; with 1000 two goals are found half as often (measured)
  double hot = 10.0;   ///< first temperature of a cycle [points of the score]; 3 loses, 30 brings nothing (measured)
  double cold = 0.01;  ///< last one [points]: differences of a hundredth decide at the end
  double structure = 0.3;  ///< share of proposals that change the sequence; in the others lengths change
  double penalty =
      300.0;  ///< first price of missing a goal by its whole distance [points]; 100 to 3000 tried (measured)
};

/// Simulated annealing over designs (Kirkpatrick, Gelatt and Vecchi 1983, "Optimization by simulated annealing",
/// Science 220, doi:10.1126/science.220.4598.671): a proposal inserts, removes, replaces or swaps modules or moves
/// lengths; what is worth d points less than the design at hand is taken with probability exp(-d / T). T falls
/// geometrically from hot to cold, then the walk is heated again. The step of the lengths grows and shrinks so that two
/// proposals in five are taken (Corana et al. 1987, ACM TOMS 13(3), doi:10.1145/29380.29864, aim at one half).
///
/// An achieved design is worth its score. One that is not achieved is worth what its types could score at best (the
/// problem's bound; its own score where there is none) less the penalty times how much is missing: otherwise the walk
/// would leave a one-module design that misses by a centimetre for any two-module design that reaches. As the bound may
/// promise what the geometry does not keep, the penalty doubles with every cycle, eight times, and begins anew.
class SimulatedAnnealing final : public SteppedSolver {
 public:
  /// Throws std::invalid_argument for an option out of range.
  explicit SimulatedAnnealing(AnnealingOptions options = {});
  [[nodiscard]] std::string name() const override { return "anneal"; }
  [[nodiscard]] const AnnealingOptions& options() const { return options_; }
  [[nodiscard]] std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const override;

 private:
  AnnealingOptions options_;
};

}  // namespace modsearch
