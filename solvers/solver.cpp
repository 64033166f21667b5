#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/solvers/solver.hpp>
#include <string_view>
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

// A bound that an achieved design exceeds is none, whoever gave it: nothing that follows from it is proved.
void hold_against(const std::optional<Incumbent>& best, const DesignProblem& problem, SearchEnd& end) {
  if (!best || !best->evaluation.attempt.achieved) return;
  const double score = best->evaluation.score;
  const double rounding = 1e-9 * std::max(1.0, std::abs(score));
  const double of_types = problem.optimism(best->design.types()).score;
  const double of_search = end.stop == StopReason::kUnreachable ? -std::numeric_limits<double>::infinity()
                           : end.bound                          ? end.bound->score
                                                                : std::numeric_limits<double>::infinity();
  const double bound = std::min(of_types, of_search);
  if (score <= bound + rounding) return;
  const std::string_view whose = of_types <= of_search ? "the problem's bound" : "the solver's bound";
  const std::string found =
      fmt::format("{} is wrong: it is {:.9g}, and an achieved design scores {:.9g}", whose, bound, score);
  end.stop = StopReason::kExhausted;
  end.bound.reset();
  end.reason += (end.reason.empty() ? "" : "; ") + found + ", so that nothing is proved";
}

}  // namespace

Solution Solver::solve(const DesignProblem& problem, Meter& meter, Rng rng) const {
  const std::optional<Infeasibility> infeasible = problem.infeasible();
  SearchEnd end = infeasible ? proved_infeasible(*infeasible, problem, meter) : do_solve(problem, meter, rng);
  hold_against(meter.best(), problem, end);
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
