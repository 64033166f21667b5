#include <modsearch/baselines/random_search.hpp>
#include <modsearch/baselines/staged.hpp>

namespace modsearch {

Design random_design(const DesignProblem& problem, Rng& rng) {
  Design design;
  std::vector<int> types;
  const int length = problem.max_modules() > 1 ? 1 + rng.index(problem.max_modules() - 1) : 0;
  while (static_cast<int>(types.size()) < length) {
    const std::vector<int> allowed = problem.successors(types);
    if (allowed.empty()) break;
    const int k = allowed[static_cast<std::size_t>(rng.index(static_cast<int>(allowed.size())))];
    const std::vector<ParameterRange>& ranges = problem.library().type(k).parameters;
    Placement placement{k, Parameters(static_cast<Eigen::Index>(ranges.size()))};
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      placement.parameters[static_cast<Eigen::Index>(i)] = rng.uniform(ranges[i].lower, ranges[i].upper);
    }
    design.modules.push_back(std::move(placement));
    types.push_back(k);
  }
  return design;
}

SearchEnd RandomSearch::do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const {
  while (evaluate_staged(meter, problem, random_design(problem, rng))) {
  }
  return {};
}

}  // namespace modsearch
