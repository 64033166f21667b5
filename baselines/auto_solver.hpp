#pragma once

#include <modsearch/solvers/solver.hpp>

namespace modsearch {

/// The default: bounds first, then per-sequence optimisation with the fastest inner method on the surviving sequences;
/// random search where the problem has no smooth program. Says in one line what it did and what is proved.
class AutoSolver final : public Solver {
 public:
  [[nodiscard]] std::string name() const override { return "auto"; }

 private:
  [[nodiscard]] SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const override;
};

}  // namespace modsearch
