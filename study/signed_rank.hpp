#pragma once

#include <span>
#include <vector>

namespace modsearch {

/// What the signed-rank test says about paired differences.
struct SignedRank {
  int pairs = 0;       ///< with a difference other than 0
  double plus = 0.0;   ///< sum of the ranks of positive differences
  double minus = 0.0;  ///< of negative ones
  double p = 1.0;      ///< two-sided: how likely so uneven sums are where the differences are symmetric about 0
  bool exact = true;   ///< from the exact distribution, else from its normal approximation
};

/// Wilcoxon's signed-rank test (1945, "Individual comparisons by ranking methods"). Differences of 0 are left out, as
/// he does (zero_method 'wilcox' of SciPy); equal sizes share the mean of their ranks. Up to 50 pairs without ties the
/// distribution is exact; else it is the normal approximation with the corrections for ties and for continuity.
/// Infinite differences rank last, tied among themselves. With no pair left p is 1. Fewer than six pairs never give
/// p < 0.05.
/// Throws std::invalid_argument if a difference is NaN.
[[nodiscard]] SignedRank signed_rank_test(std::span<const double> differences);

/// p-values adjusted for the number of tests: rejecting those below a level keeps the probability of one false
/// rejection or more below that level. Source: Holm 1979, "A simple sequentially rejective multiple test procedure".
/// Throws std::invalid_argument if one is outside [0, 1].
[[nodiscard]] std::vector<double> holm_adjusted(std::span<const double> p);

}  // namespace modsearch
