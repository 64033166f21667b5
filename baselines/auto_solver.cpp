#include <fmt/format.h>

#include <modsearch/baselines/auto_solver.hpp>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/baselines/random_search.hpp>

namespace modsearch {
namespace {

// Some sequence of one module has a smooth program.
bool has_smooth_programs(const DesignProblem& problem) {
  for (const int k : problem.successors({})) {
    const int types[] = {k};
    if (problem.relax(types)) return true;
  }
  return false;
}

SearchEnd end_of(const std::string& method, Solution&& solution) {
  return {solution.stop, solution.reason.empty() ? method : fmt::format("{}: {}", method, solution.reason),
          std::move(solution.bound)};
}

}  // namespace

SearchEnd AutoSolver::do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const {
  if (has_smooth_programs(problem)) {
    const PerSequence method{};
    return end_of(method.name(), method.solve(problem, meter, rng));
  }
  const RandomSearch method{};
  return end_of(method.name(), method.solve(problem, meter, rng));
}

}  // namespace modsearch
