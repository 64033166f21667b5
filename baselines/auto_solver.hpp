#pragma once

#include <modsearch/solvers/search.hpp>

namespace modsearch {

/// The default: chooses by the problem and says in one line what it did and what is proved.
///
/// Bounds come first in all of it: what no design can reach is said at once, and type sequences are taken in falling
/// order of the score that is possible. Modules without parameters: `eliminate`, which proves its answer. Modules with
/// parameters and a smooth program: `per-sequence` with the fastest inner method, and then, for a moment,
/// `branch-and-bound`, which proves the answer where that is cheap. Where there are more type sequences than can be
/// gone through, or many and the first 60 show no achieved design, evolution (`ga`) goes on; so it does from the
/// beginning where there is no smooth program.
class AutoSolver final : public SteppedSolver {
 public:
  [[nodiscard]] std::string name() const override { return "auto"; }
  [[nodiscard]] std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const override;
};

}  // namespace modsearch
