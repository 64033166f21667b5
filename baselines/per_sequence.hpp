#pragma once

#include <modsearch/solvers/inner_solver.hpp>
#include <modsearch/solvers/solver.hpp>

namespace modsearch {

struct PerSequenceOptions {
  Inner inner = Inner::kOwn;  ///< method for the smooth program of each sequence: the fastest
  /// Low-discrepancy starts per sequence. Eight: local methods solve 60-95 % of single starts on chains of up to five
  /// joints, so eight miss a sequence in less than one case in a thousand.
  int starts = 8;
  InnerOptions inner_options{};
};

/// Per-sequence continuous optimisation: type sequences in order of an optimistic bound (modules, mass by reach), each
/// solved as a smooth program from several starts, until no remaining sequence can beat the best.
///
/// The program is a relaxation (it ignores which posture the score looks at), so every optimum is evaluated for real; where
/// it is in collision after all, the program is solved again with a larger clearance. Sequences are exact, starts are
/// not: nothing is proved about the best of a sequence.
class PerSequence final : public Solver {
 public:
  explicit PerSequence(PerSequenceOptions options = {});
  [[nodiscard]] std::string name() const override;
  [[nodiscard]] const PerSequenceOptions& options() const { return options_; }

 private:
  [[nodiscard]] SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const override;
  void solve_sequence(const DesignProblem& problem, std::span<const int> types, Meter& meter, Rng rng) const;

  PerSequenceOptions options_;
};

}  // namespace modsearch
