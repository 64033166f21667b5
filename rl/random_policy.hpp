#pragma once

#include <modsearch/rl/acting.hpp>
#include <modsearch/solvers/solver.hpp>
#include <string>

namespace modsearch {

struct RandomPolicyOptions {
  int proposals = 1;               ///< per placement; the best by its true reward is carried out
  int polish = 3;                  ///< Gauss-Newton steps on each proposal at most; as in preset best
  PolishOptions polishing{};       ///< how they are done
  std::string type{};              ///< proposes modules with this ID only; empty: any that may follow, uniformly
};

/// A policy that has learned nothing: each placement is the best of some random proposals, refined as those of agents
/// are. The control that stands beside every agent that acts with polish: what it shows is what the polish is worth,
/// and only what an agent does better was learned. Ends when the design achieves its task.
class RandomPolicy final : public Solver {
 public:
  /// Throws std::invalid_argument unless there is at least one proposal and no negative number of steps.
  explicit RandomPolicy(RandomPolicyOptions options = {});
  [[nodiscard]] std::string name() const override { return "random"; }

 private:
  /// Throws std::invalid_argument where the library has no module `type`.
  [[nodiscard]] SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const override;

  RandomPolicyOptions options_;
};

}  // namespace modsearch
