#pragma once

#include <modsearch/baselines/sequence_optimum.hpp>
#include <modsearch/solvers/search.hpp>

namespace modsearch {

struct EnumerateOptions {
  PerSequenceOptions continuous{};  ///< how a sequence with parameters and a smooth program is optimised
  /// Random designs of a sequence that has parameters and no smooth program. Arbitrary.
  int samples = 64;
};

/// Exact enumeration, best-first: type sequences in falling order of an admissible bound (modules, mass by reach),
/// built from prefixes that could still win, until nothing left can beat the best.
///
/// A sequence without parameters is one design, evaluated. Where that holds for all that could win, the answer is
/// proved: StopReason::kOptimal, or kUnreachable where none is achieved. Of sequences with parameters only the bound is
/// proved, and the solution says how far up it leaves things open.
class Enumerate final : public SteppedSolver {
 public:
  /// Throws std::invalid_argument for less than one start or sample.
  explicit Enumerate(EnumerateOptions options = {});
  [[nodiscard]] std::string name() const override { return "enumerate"; }
  [[nodiscard]] const EnumerateOptions& options() const { return options_; }
  [[nodiscard]] std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const override;

 private:
  EnumerateOptions options_;
};

}  // namespace modsearch
