#pragma once

#include <checker/bound.hpp>

namespace modsearch_check {

/// What the leaves of all trees were.
struct Count {
  std::size_t sequences = 0;
  std::size_t excluded = 0;  // sequences without a tree, by the checker's own reach test
  std::size_t leaves = 0;
};

/// Checks the tree of one sequence: that its leaves cover the root box, and that each shows that no achieved design in
/// its box scores above `upper` (-inf: that none is achieved). Throws Malformed and Rejected.
void check_tree(const Problem& problem, const Model& model, const Value& tree, double upper, Count& count);

/// An upper bound of the score of every achieved design of `n` modules (base included) that weighs `mass` at least and
/// costs `costs`.
[[nodiscard]] double best_score(const Problem& problem, std::size_t n, const Interval& costs, double mass);

}  // namespace modsearch_check
