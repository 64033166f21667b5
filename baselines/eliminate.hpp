#pragma once

#include <modsearch/solvers/search.hpp>

namespace modsearch {

struct EliminateOptions {
  /// Values that each continuous parameter takes, evenly spaced from its lower to its upper end; 1: its middle. Three:
  /// the ends and the middle, the coarsest grid that has all of them.
  int grid = 3;
};

/// Hierarchical elimination: every design of a discrete space passes tests from cheap to dear and drops out at the
/// first that it fails, so that the dear ones see few. Connectors and completeness are counted without building a
/// design, reach and the score that is possible come from bounds of prefixes, then poses (inverse kinematics within the
/// joint limits), bodies at the goals, and the path, whatever of these the problem has (DesignProblem::stages). What
/// each stage removed is told in the solution's tallies; a reason of failure that a problem adds is a stage of its own.
///
/// Source: Liu and Althoff 2020, "Optimizing Performance in Automation through Modular Robots", ICRA,
/// doi:10.1109/ICRA40945.2020.9196590. Ours: designs go through one by one in falling order of the score that is
/// possible, not stage by stage, so that the first that pass also remove by score.
///
/// Exact where modules have no parameters; otherwise the best of the grid.
class Eliminate final : public SteppedSolver {
 public:
  /// Throws std::invalid_argument for a grid that is not in [1, 1000].
  explicit Eliminate(EliminateOptions options = {});
  [[nodiscard]] std::string name() const override { return "eliminate"; }
  [[nodiscard]] const EliminateOptions& options() const { return options_; }
  [[nodiscard]] std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const override;

 private:
  EliminateOptions options_;
};

}  // namespace modsearch
