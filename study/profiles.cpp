#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/study/profiles.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

// Number of problems, after a look at the table's shape.
std::size_t checked_problems(const RuntimeTable& runtimes, const char* who) {
  if (runtimes.empty() || runtimes[0].empty()) {
    throw std::invalid_argument(fmt::format("{}: the table of runtimes is empty", who));
  }
  for (const std::vector<double>& row : runtimes) {
    if (row.size() != runtimes[0].size()) {
      throw std::invalid_argument(
          fmt::format("{}: a solver has {} runtimes, another {}", who, row.size(), runtimes[0].size()));
    }
    for (const double runtime : row) {
      if (!(runtime >= 0.0)) throw std::invalid_argument(fmt::format("{}: a runtime is {}", who, runtime));
    }
  }
  return runtimes[0].size();
}

std::vector<StepFunction> distributions(const RuntimeTable& table) {
  std::vector<StepFunction> out;
  for (const std::vector<double>& row : table) out.push_back(empirical_distribution(row));
  return out;
}

}  // namespace

std::vector<StepFunction> data_profiles(const RuntimeTable& runtimes, std::span<const int> dimensions) {
  const std::size_t problems = checked_problems(runtimes, "data_profiles");
  if (dimensions.size() != problems) {
    throw std::invalid_argument(
        fmt::format("data_profiles: {} dimensions for {} problems", dimensions.size(), problems));
  }
  if (std::any_of(dimensions.begin(), dimensions.end(), [](int dimension) { return dimension < 0; })) {
    throw std::invalid_argument("data_profiles: a dimension is negative");
  }
  RuntimeTable gradients = runtimes;
  for (std::vector<double>& row : gradients) {
    for (std::size_t p = 0; p < problems; ++p) row[p] /= dimensions[p] + 1;
  }
  return distributions(gradients);
}

std::vector<StepFunction> performance_profiles(const RuntimeTable& runtimes) {
  const std::size_t problems = checked_problems(runtimes, "performance_profiles");
  RuntimeTable ratios = runtimes;
  for (std::size_t p = 0; p < problems; ++p) {
    double best = INFINITY;
    for (const std::vector<double>& row : runtimes) best = std::min(best, row[p]);
    for (std::vector<double>& row : ratios) {
      const double runtime = row[p];
      // Written so that neither inf / inf nor 0 / 0 is formed.
      row[p] = !std::isfinite(runtime) ? INFINITY : runtime == best ? 1.0 : runtime / best;
    }
  }
  return distributions(ratios);
}

}  // namespace modsearch
