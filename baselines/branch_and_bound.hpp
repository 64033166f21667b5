#pragma once

#include <modsearch/solvers/search.hpp>

namespace modsearch {

struct BranchAndBoundOptions {
  /// Ends when the best possible score is at most this share of the best design's mass above it (in points of the mass;
  /// where mass costs nothing, of the score). A tenth of a per mille: 0.0008 points on `seed/fixed`.
  double gap = 1e-4;
  /// Ends after so many boxes were cut in two; 0: no limit. For a look at what can be had cheaply.
  std::int64_t boxes = 0;
};

/// Certified branch and bound: finds the best design and proves, up to `gap`, that no other scores more. Over all type
/// sequences at once, best-first; for one sequence over boxes of lengths and joint angles, each closed by multipliers
/// of the goals and of what obstacles forbid (docs/certificates.md has the bound and the search).
///
/// The solution's bound holds at any moment, for the collision level `posture`: it stays valid at the levels that
/// forbid more. Robot problems whose goals are balls about positions, whose joints turn and whose parameters are
/// lengths; about others nothing is proved but reach, and `enumerate` does the work.
class BranchAndBound final : public SteppedSolver {
 public:
  /// Throws std::invalid_argument for a gap that is not in (0, 1] or a negative limit.
  explicit BranchAndBound(BranchAndBoundOptions options = {});
  [[nodiscard]] std::string name() const override { return "branch-and-bound"; }
  [[nodiscard]] const BranchAndBoundOptions& options() const { return options_; }
  /// Whether more than reach can be proved about designs of `problem`.
  [[nodiscard]] bool covers(const DesignProblem& problem) const;
  [[nodiscard]] std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const override;

 private:
  BranchAndBoundOptions options_;
};

}  // namespace modsearch
