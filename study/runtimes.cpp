#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/study/runtimes.hpp>
#include <stdexcept>

namespace modsearch {

double expected_runtime(std::span<const TargetRun> runs) {
  if (runs.empty()) throw std::invalid_argument("expected_runtime: there are no runs");
  double spent = 0.0;
  int met = 0;
  for (const TargetRun& run : runs) {
    if (!(run.spent >= 0.0)) throw std::invalid_argument(fmt::format("expected_runtime: a run spent {}", run.spent));
    spent += run.spent;
    met += run.met ? 1 : 0;
  }
  return met > 0 ? spent / met : std::numeric_limits<double>::infinity();
}

Proportion success_rate(int successes, int trials) {
  if (trials < 1 || successes < 0 || successes > trials) {
    throw std::invalid_argument(fmt::format("success_rate: {} successes in {} trials", successes, trials));
  }
  constexpr double z = 1.959963984540054;  // the standard normal distribution is below it with probability 0.975
  const double n = trials;
  const double share = successes / n;
  const double centre = (share + z * z / (2.0 * n)) / (1.0 + z * z / n);
  const double half = z / (1.0 + z * z / n) * std::sqrt(share * (1.0 - share) / n + z * z / (4.0 * n * n));
  // At the ends the bounds are 0 and 1 exactly, which rounding would miss.
  return {share, successes == 0 ? 0.0 : centre - half, successes == trials ? 1.0 : centre + half};
}

}  // namespace modsearch
