#pragma once

#include <limits>
#include <span>

namespace modsearch {

/// How a run fared with one target, in evaluations or in seconds.
struct TargetRun {
  double spent = 0.0;  ///< until the target was met, or altogether where it was not
  bool met = false;

  /// The runtime: infinite where the target was not met.
  [[nodiscard]] double runtime() const { return met ? spent : std::numeric_limits<double>::infinity(); }
};

/// Expected runtime (ERT) of a solver that is started again until it meets the target: everything that all runs spent,
/// divided by the number of those that met it; infinite if none did. Source: Hansen et al. 2016, "COCO: performance
/// assessment", arXiv:1605.03560, section 4.1 (there: average runtime, aRT).
/// Throws std::invalid_argument if there is no run or one spent a negative amount.
[[nodiscard]] double expected_runtime(std::span<const TargetRun> runs);

/// A share of successes with its 95 % interval.
struct Proportion {
  double value = 0.0;
  double low = 0.0;
  double high = 1.0;
};

/// Successes per trial with the score interval of Wilson (1927), "Probable inference, the law of succession, and
/// statistical inference", which keeps its level for few trials and for shares near 0 and 1.
/// Throws std::invalid_argument unless 0 <= successes <= trials and trials >= 1.
[[nodiscard]] Proportion success_rate(int successes, int trials);

}  // namespace modsearch
