#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/study/distribution.hpp>
#include <stdexcept>

namespace modsearch {

double StepFunction::operator()(double x) const {
  const auto after = std::upper_bound(at.begin(), at.end(), x);
  return after == at.begin() ? 0.0 : value[static_cast<std::size_t>(after - at.begin()) - 1];
}

StepFunction empirical_distribution(std::span<const double> values) {
  if (values.empty()) throw std::invalid_argument("empirical_distribution: there are no values");
  std::vector<double> sorted(values.begin(), values.end());
  for (const double value : sorted) {
    if (std::isnan(value) || value == -INFINITY) {
      throw std::invalid_argument(fmt::format("empirical_distribution: a value is {}", value));
    }
  }
  std::sort(sorted.begin(), sorted.end());
  StepFunction out;
  for (std::size_t i = 0; i < sorted.size() && std::isfinite(sorted[i]); ++i) {
    const double share = static_cast<double>(i + 1) / static_cast<double>(sorted.size());
    if (!out.at.empty() && out.at.back() == sorted[i]) {
      out.value.back() = share;
    } else {
      out.at.push_back(sorted[i]);
      out.value.push_back(share);
    }
  }
  return out;
}

double quantile(std::vector<double> values, double p) {
  if (values.empty()) throw std::invalid_argument("quantile: there are no values");
  if (!(p >= 0.0 && p <= 1.0)) throw std::invalid_argument(fmt::format("quantile: p is {}, not in [0, 1]", p));
  if (std::any_of(values.begin(), values.end(), [](double value) { return std::isnan(value); })) {
    throw std::invalid_argument("quantile: a value is NaN");
  }
  const double place = p * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), values.begin() + below, values.end());
  const double low = values[static_cast<std::size_t>(below)];
  const double weight = place - static_cast<double>(below);
  if (weight == 0.0) return low;
  const double high = *std::min_element(values.begin() + below + 1, values.end());
  // Equal neighbours may be infinite, and inf - inf is no number.
  return low == high ? low : low + weight * (high - low);
}

}  // namespace modsearch
