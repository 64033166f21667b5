#pragma once

#include <modsearch/study/distribution.hpp>
#include <span>
#include <vector>

namespace modsearch {

/// Runtimes to one target: [n_solvers x n_problems], infinite where a solver does not meet it.
using RuntimeTable = std::vector<std::vector<double>>;

/// Per solver, the share of problems that it solves within alpha simplex gradients, as a function of alpha: the runtime
/// of problem p is divided by dimensions[p] + 1. Source: Moré and Wild 2009, "Benchmarking derivative-free optimization
/// algorithms", SIAM J. Optim. 20, equation (2.8), doi:10.1137/080724083.
/// Throws std::invalid_argument unless every solver has one runtime per problem and the dimensions are not negative.
[[nodiscard]] std::vector<StepFunction> data_profiles(const RuntimeTable& runtimes, std::span<const int> dimensions);

/// Per solver, the share of problems on which it needs at most tau times what the best solver of that problem needs, as
/// a function of tau >= 1. A problem that nobody solves counts for nobody. Source: Dolan and Moré 2002, "Benchmarking
/// optimization software with performance profiles", Math. Program. 91, section 2, doi:10.1007/s101070100263. Mind that
/// the ratios depend on who takes part: profiles of three solvers do not rank the second against the third (Gould and
/// Scott 2016, doi:10.1145/2950048).
/// Throws std::invalid_argument unless every solver has one runtime >= 0 per problem.
[[nodiscard]] std::vector<StepFunction> performance_profiles(const RuntimeTable& runtimes);

}  // namespace modsearch
