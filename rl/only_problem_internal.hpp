#pragma once

#include <memory>
#include <modsearch/problem/problem_source.hpp>

namespace modsearch::detail {

/// A problem as its own family; it must outlive the source.
[[nodiscard]] inline ProblemSource only(const DesignProblem& problem) {
  const std::shared_ptr<const DesignProblem> borrowed{std::shared_ptr<const DesignProblem>{}, &problem};
  return [borrowed](Rng) { return borrowed; };
}

}  // namespace modsearch::detail
