#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/study/bootstrap.hpp>
#include <modsearch/study/distribution.hpp>
#include <numeric>
#include <stdexcept>

namespace modsearch {
namespace {

void check(const Strata& results, const BootstrapOptions& options, const char* who) {
  if (options.resamples < 1) {
    throw std::invalid_argument(fmt::format("{}: {} resamples, at least 1 is needed", who, options.resamples));
  }
  if (results.empty()) throw std::invalid_argument(fmt::format("{}: there are no tasks", who));
  for (const std::vector<double>& runs : results) {
    if (runs.empty()) throw std::invalid_argument(fmt::format("{}: a task has no runs", who));
    if (std::any_of(runs.begin(), runs.end(), [](double value) { return std::isnan(value); })) {
      throw std::invalid_argument(fmt::format("{}: a value is NaN", who));
    }
  }
}

// As many runs of every task as there are, drawn with replacement.
Strata resampled(const Strata& results, Rng& rng) {
  Strata out = results;
  for (std::size_t task = 0; task < results.size(); ++task) {
    for (double& run : out[task]) {
      run = results[task][static_cast<std::size_t>(rng.index(static_cast<int>(results[task].size())))];
    }
  }
  return out;
}

std::vector<double> flat(const Strata& results) {
  std::vector<double> out;
  for (const std::vector<double>& runs : results) out.insert(out.end(), runs.begin(), runs.end());
  return out;
}

// `statistic` of the results themselves and the middle 95 % of `resample`, which draws results anew and takes it.
template <class Resample>
Estimate estimate(double statistic, Resample resample, const BootstrapOptions& options) {
  std::vector<double> draws(static_cast<std::size_t>(options.resamples));
  for (double& draw : draws) draw = resample();
  return {statistic, quantile(draws, 0.025), quantile(draws, 0.975)};
}

double won_share(std::span<const double> first, std::span<const double> second) {
  double won = 0.0;
  for (const double a : first) {
    for (const double b : second) won += a > b ? 1.0 : a == b ? 0.5 : 0.0;
  }
  return won / static_cast<double>(first.size() * second.size());
}

double mean_won_share(const Strata& first, const Strata& second) {
  double sum = 0.0;
  for (std::size_t task = 0; task < first.size(); ++task) sum += won_share(first[task], second[task]);
  return sum / static_cast<double>(first.size());
}

}  // namespace

double interquartile_mean(std::vector<double> values) {
  check({values}, {}, "interquartile_mean");
  const auto cut = static_cast<std::ptrdiff_t>(values.size() / 4);
  std::sort(values.begin(), values.end());
  return std::accumulate(values.begin() + cut, values.end() - cut, 0.0) /
         static_cast<double>(values.size() - 2 * static_cast<std::size_t>(cut));
}

Estimate interquartile_mean(const Strata& results, Rng rng, BootstrapOptions options) {
  check(results, options, "interquartile_mean");
  return estimate(
      interquartile_mean(flat(results)), [&] { return interquartile_mean(flat(resampled(results, rng))); }, options);
}

Estimate probability_of_improvement(const Strata& first, const Strata& second, Rng rng, BootstrapOptions options) {
  check(first, options, "probability_of_improvement");
  check(second, options, "probability_of_improvement");
  if (first.size() != second.size()) {
    throw std::invalid_argument(
        fmt::format("probability_of_improvement: {} tasks against {}", first.size(), second.size()));
  }
  const auto resample = [&] {
    const Strata drawn = resampled(first, rng);
    return mean_won_share(drawn, resampled(second, rng));
  };
  return estimate(mean_won_share(first, second), resample, options);
}

}  // namespace modsearch
