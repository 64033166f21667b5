#pragma once

#include <memory>
#include <modsearch/baselines/sequence_optimum.hpp>
#include <modsearch/solvers/solver.hpp>

namespace modsearch {

/// Another solver, and then the smooth program of the type sequence of its best design: the first chooses the modules,
/// the second their lengths. With a learned policy in front it is the division of labour that hybrid agents learn,
/// with the continuous half solved instead of learned. Both share one budget: a search that spends all of it leaves
/// nothing for the program.
class Refined final : public Solver {
 public:
  /// Throws std::invalid_argument without a solver, or for less than one start.
  explicit Refined(std::shared_ptr<const Solver> first, PerSequenceOptions options = {});
  [[nodiscard]] std::string name() const override;

 private:
  [[nodiscard]] SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const override;

  std::shared_ptr<const Solver> first_;
  PerSequenceOptions options_;
};

}  // namespace modsearch
