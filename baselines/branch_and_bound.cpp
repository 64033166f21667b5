#include <fmt/format.h>

#include <modsearch/baselines/branch_and_bound.hpp>
#include <modsearch/baselines/certify/bound_search_internal.hpp>
#include <modsearch/baselines/enumerate.hpp>
#include <stdexcept>

namespace modsearch {

BranchAndBound::BranchAndBound(BranchAndBoundOptions options) : options_{options} {
  if (!(options_.gap > 0.0 && options_.gap <= 1.0)) {
    throw std::invalid_argument(fmt::format("branch-and-bound: gap is {}, not in (0, 1]", options_.gap));
  }
}

std::unique_ptr<Search> BranchAndBound::start(const DesignProblem& problem, Rng rng) const {
  const auto* robot = dynamic_cast<const RobotProblem*>(&problem);
  if (robot == nullptr || certify::why_not_covered(*robot)) return Enumerate{}.start(problem, rng);
  return std::make_unique<certify::BoundSearch>(*robot, options_.gap);
}

}  // namespace modsearch
