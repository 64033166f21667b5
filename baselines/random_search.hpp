#pragma once

#include <modsearch/solvers/search.hpp>

namespace modsearch {

/// A module of type `k` with uniform parameters. Throws std::invalid_argument for an unknown type.
[[nodiscard]] Placement random_placement(const ModuleLibrary& library, int k, Rng& rng);

/// A design with a uniform number of modules in 1 .. max_modules - 1, uniform types among those that may follow, and
/// uniform parameters. Shorter only where nothing may follow.
[[nodiscard]] Design random_design(const DesignProblem& problem, Rng& rng);

/// Draws designs at random until the budget is spent: the bar that every method has to clear.
class RandomSearch final : public SteppedSolver {
 public:
  [[nodiscard]] std::string name() const override { return "random"; }
  [[nodiscard]] std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const override;
};

}  // namespace modsearch
