#pragma once

namespace modsearch {

/// What a trained solver costs at the quality it is compared at, in evaluations or in seconds.
struct AmortisedCost {
  double training = 0.0;  ///< once, tuning left out
  double use = 0.0;       ///< per task; infinite where the quality is not met

  /// Cost per task where the training is shared by `tasks` > 0 of them.
  [[nodiscard]] double per_task(double tasks) const { return training / tasks + use; }
};

/// The number of tasks N* from which a trained solver costs no more per task than a classical one at equal quality:
/// training / (classical - use). 0 without a training that costs anything; infinite where its use is not cheaper.
/// `classical`: cost per task, infinite where the classical solver does not meet the quality.
/// Throws std::invalid_argument if a cost is negative or NaN.
[[nodiscard]] double break_even_tasks(const AmortisedCost& trained, double classical);

}  // namespace modsearch
