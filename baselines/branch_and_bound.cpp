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
  if (options_.boxes < 0) {
    throw std::invalid_argument(fmt::format("branch-and-bound: boxes is {}, at least 0 is needed", options_.boxes));
  }
}

bool BranchAndBound::covers(const DesignProblem& problem) const {
  const auto* robot = dynamic_cast<const RobotProblem*>(&problem);
  return robot != nullptr && !certify::why_not_covered(*robot);
}

std::unique_ptr<Search> BranchAndBound::start(const DesignProblem& problem, Rng rng) const {
  if (!covers(problem)) return Enumerate{}.start(problem, rng);
  return std::make_unique<certify::BoundSearch>(
      dynamic_cast<const RobotProblem&>(problem),
      certify::BoundSearchOptions{.gap = options_.gap, .most_boxes = options_.boxes});
}

}  // namespace modsearch
