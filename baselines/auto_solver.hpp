#pragma once

#include <modsearch/solvers/search.hpp>

namespace modsearch {

/// The default: chooses by the problem and says in one line what it did and what is proved.
///
/// Bounds come first in all of it: what no design can reach is said at once, and type sequences are taken in falling
/// order of the score that is possible. Modules without parameters: `eliminate`, which proves its answer. Modules with
/// parameters and a smooth program: `per-sequence` with the fastest inner method, and then, for a moment,
/// `branch-and-bound`, which proves the answer where that is cheap. Goals that ask for orientations and more than a
/// thousand type sequences: `pose-first` from the beginning, because single sequences meet such goals by luck. Where
/// there are more type sequences than can be gone through, or the first show no achieved design, `pose-first` goes on
/// where the problem has poses to be solved for, else evolution (`ga`).
class AutoSolver final : public SteppedSolver {
 public:
  [[nodiscard]] std::string name() const override { return "auto"; }
  [[nodiscard]] std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const override;
};

}  // namespace modsearch
