#include <modsearch/solvers/solver.hpp>
#include <utility>

namespace modsearch {

Solution Solver::solve(const DesignProblem& problem, Meter& meter, Rng rng) const {
  SearchEnd end = do_solve(problem, meter, rng);
  const bool proved = end.stop == StopReason::kOptimal || end.stop == StopReason::kUnreachable;
  Solution solution;
  if (meter.best()) {
    solution.design = meter.best()->design;
    solution.evaluation = meter.best()->evaluation;
  }
  solution.nearest = meter.nearest();
  solution.spent = meter.progress();
  solution.stop = proved ? end.stop : meter.stopped().value_or(end.stop);
  solution.reason = std::move(end.reason);
  solution.bound = std::move(end.bound);
  solution.tallies = std::move(end.tallies);
  return solution;
}

}  // namespace modsearch
