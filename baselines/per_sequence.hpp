#pragma once

#include <modsearch/baselines/sequence_optimum.hpp>
#include <modsearch/solvers/search.hpp>

namespace modsearch {

/// Per-sequence continuous optimisation: type sequences in order of an optimistic bound (modules, mass by reach), each
/// solved as a smooth program from several starts, until no remaining sequence can beat the best.
///
/// The program is a relaxation (it ignores which posture the score looks at), so every optimum is evaluated for real;
/// where it is in collision after all, the program is solved again with a larger clearance. Sequences are exact, starts
/// are not: of the best of a sequence nothing is proved but its bound.
class PerSequence final : public SteppedSolver {
 public:
  /// Throws std::invalid_argument for less than one start.
  explicit PerSequence(PerSequenceOptions options = {});
  [[nodiscard]] std::string name() const override;
  [[nodiscard]] const PerSequenceOptions& options() const { return options_; }
  [[nodiscard]] std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const override;

 private:
  PerSequenceOptions options_;
};

}  // namespace modsearch
