#pragma once

#include <span>
#include <vector>

namespace modsearch {

/// A distribution function: it is 0 below at[0], and value[i] from at[i] on until at[i + 1].
struct StepFunction {
  std::vector<double> at;     ///< strictly increasing, finite
  std::vector<double> value;  ///< [at.size()], increasing, in (0, 1]

  /// The value at `x`: the share that is at most x.
  [[nodiscard]] double operator()(double x) const;
};

/// Share of `values` that are at most x, as a function of x. Infinite values are never reached, so the function ends
/// below 1: that is how runs that miss a target enter an ECDF of runtimes (Hansen et al. 2016, "COCO: performance
/// assessment", arXiv:1605.03560, section 5; without its simulated restarts).
/// Throws std::invalid_argument if there is no value or one is NaN or -inf.
[[nodiscard]] StepFunction empirical_distribution(std::span<const double> values);

/// The quantile at `p` in [0, 1] with linear interpolation between order statistics: definition 7 of Hyndman and Fan
/// (1996), "Sample quantiles in statistical packages", the default of NumPy and R. `values` may be infinite.
/// Throws std::invalid_argument if there is no value, one is NaN, or p is outside [0, 1].
[[nodiscard]] double quantile(std::vector<double> values, double p);

}  // namespace modsearch
