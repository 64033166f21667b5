#pragma once

#include <modsearch/problem/design_problem.hpp>
#include <modsearch/problem/rng.hpp>
#include <optional>
#include <vector>

namespace modsearch::detail {

/// A type sequence made of another one, and which of its modules stay.
struct SequenceChange {
  std::vector<int> types;
  std::vector<int> from;          ///< [modules] where each stood before; -1: it is new
  std::vector<int> parameters{};  ///< [parameters] index of each among the old ones; -1: new
  std::vector<int> joints{};      ///< likewise [joints]
  int old_parameters = 0;
  int old_joints = 0;
};

/// `types` with a random module removed, replaced or put in, or two exchanged, complete and fitting together; removing
/// is tried most often, since less is better. Nothing: a number of tries gave none.
[[nodiscard]] std::optional<SequenceChange> changed(const DesignProblem& problem, const std::vector<int>& types,
                                                    Rng& rng);

/// A start for the changed sequence from the variables (x, q_goal1, ..) of the old one: what stays keeps its value,
/// what is new is drawn, and all is shaken, more and more with `i`. `lower` and `upper` are the bounds.
void carry_over(const SequenceChange& change, const Eigen::VectorXd& old, int i, const Eigen::VectorXd& lower,
                const Eigen::VectorXd& upper, Rng& rng, Eigen::Ref<Eigen::VectorXd> v);

}  // namespace modsearch::detail
