#pragma once

#include <modsearch/solvers/inner_solver.hpp>
#include <modsearch/solvers/search.hpp>

namespace modsearch {

struct TreeSearchOptions {
  double exploration = 1.0;  ///< c of UCT, for values in [0, 1]; 0.3 stays with the first that is achieved. 0: greedy
  /// Progressive widening: a type that was chosen n times at a node has at most ceil(width * n^growth) modules with
  /// different parameters there. Arbitrary; the source of the idea has growth in (0, 1).
  double width = 2.0;
  double growth = 0.5;
  double uniform = 0.3;  ///< share of new parameters drawn from the whole box, the others near the best. Arbitrary
  bool rollout = true;   ///< grow a new design at random, too, where more modules could still win
  int polish = 20;       ///< most steps of the smooth program on a new design that is the best of its types; 0: none
  Inner inner = Inner::kOwn;  ///< method of the polish: the fastest
};

/// Monte-Carlo tree search that grows designs module by module, as agents do: a node is a design, a move attaches a
/// module with its parameters. The type is chosen by UCT (Kocsis and Szepesvari 2006, doi:10.1007/11871842_29), its
/// parameters by progressive widening (Couetoux et al. 2011, doi:10.1007/978-3-642-25566-3_32): either one of those
/// tried before, again by UCT, or new ones by Voronoi optimistic optimisation, i.e. from the cell of the best so far or
/// from the whole box (Kim, Lee, Lim, Kaelbling and Lozano-Perez 2020, "Monte Carlo Tree Search in Continuous Spaces
/// Using Voronoi Optimistic Optimization with Regret Bounds", AAAI 34(06), doi:10.1609/aaai.v34i06.6546).
///
/// Evaluating is a function of the design, so a node is worth the best below it and not the mean. Every prefix is a
/// design: a new node is evaluated itself, and by one random continuation. Values are ranks
/// (baselines/lexicographic.hpp) on a scale of [0, 1]. Two things are ours: whatever cannot beat the best by its bound
/// is cut off, and once more modules cannot, what counts of a design is its own rank. Where nothing is left, the search
/// has proved it.
class TreeSearch final : public SteppedSolver {
 public:
  /// Throws std::invalid_argument for an option out of range.
  explicit TreeSearch(TreeSearchOptions options = {});
  [[nodiscard]] std::string name() const override { return "mcts"; }
  [[nodiscard]] const TreeSearchOptions& options() const { return options_; }
  [[nodiscard]] std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const override;

 private:
  TreeSearchOptions options_;
};

}  // namespace modsearch
