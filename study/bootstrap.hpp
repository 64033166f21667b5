#pragma once

#include <modsearch/problem/rng.hpp>
#include <span>
#include <vector>

namespace modsearch {

/// Results of one solver: [n_tasks][n_runs of the task]. A task is a stratum: runs are resampled within it.
using Strata = std::vector<std::vector<double>>;

/// A number with its 95 % interval.
struct Estimate {
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
};

struct BootstrapOptions {
  int resamples = 2000;  ///< rliable's choice for pairs of algorithms; the ends of the interval settle to two digits
};

/// The mean of the middle half: the lowest and the highest quarter of all values are left out, each rounded down to
/// whole values (a trimmed mean of 25 %). `values` may be infinite: the mean is too if one of the middle half is.
/// Throws std::invalid_argument if there is no value or one is NaN.
[[nodiscard]] double interquartile_mean(std::vector<double> values);

/// The interquartile mean over all runs of all tasks, with the percentile interval of a bootstrap that resamples the
/// runs of every task by themselves. Source: Agarwal et al. 2021, "Deep reinforcement learning at the edge of the
/// statistical precipice", arXiv:2108.13264, section 4 (the library rliable).
/// Throws std::invalid_argument if a task has no run, a value is NaN, or resamples < 1.
[[nodiscard]] Estimate interquartile_mean(const Strata& results, Rng rng, BootstrapOptions options = {});

/// How likely a run of `first` is better (larger) than a run of `second` on a task drawn at random: per task the share
/// of pairs of runs that `first` wins, ties counting half (Mann and Whitney's U divided by the number of pairs),
/// averaged over the tasks; with the percentile interval of a stratified bootstrap. Source: as above, section 4.3
/// (probability of improvement; Vargha and Delaney's A of each task). Throws std::invalid_argument unless both have the
/// same number of tasks, every task has runs, and no value is NaN.
[[nodiscard]] Estimate probability_of_improvement(const Strata& first, const Strata& second, Rng rng,
                                                  BootstrapOptions options = {});

}  // namespace modsearch
