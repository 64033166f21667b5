#include <fmt/format.h>

#include <modsearch/baselines/pose_first.hpp>
#include <modsearch/baselines/pose_first/pose_search_internal.hpp>
#include <stdexcept>

namespace modsearch {

PoseFirst::PoseFirst(PoseFirstOptions options) : options_{options} {
  if (options_.starts < 1 || options_.iterations < 1) {
    throw std::invalid_argument(fmt::format("pose-first: starts ({}) and iterations ({}) must be at least 1",
                                            options_.starts, options_.iterations));
  }
}

bool PoseFirst::covers(const DesignProblem& problem) {
  const std::vector<int> first = problem.successors({});
  return !first.empty() && problem.pose_program(std::span{first}.first(1)) != nullptr;
}

std::unique_ptr<Search> PoseFirst::start(const DesignProblem& problem, Rng rng) const {
  return std::make_unique<detail::PoseSearch>(options_, problem, rng);
}

}  // namespace modsearch
