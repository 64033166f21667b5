#include <modsearch/solvers/solver.hpp>
#include <utility>

namespace modsearch {
namespace {

// The end of a search that need not begin. The empty design is evaluated, as by most searches: there is an answer, and
// how far it is from the goals.
SearchEnd proved_infeasible(const Infeasibility& why, const DesignProblem& problem, Meter& meter) {
  static_cast<void>(meter.evaluate(problem, Design{}));
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  return {.stop = StopReason::kUnreachable,
          .reason = "proved infeasible: " + why.reason,
          .bound = Bound{kNone, "proved infeasible"}};
}

}  // namespace

Solution Solver::solve(const DesignProblem& problem, Meter& meter, Rng rng) const {
  const std::optional<Infeasibility> infeasible = problem.infeasible();
  SearchEnd end = infeasible ? proved_infeasible(*infeasible, problem, meter) : do_solve(problem, meter, rng);
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
