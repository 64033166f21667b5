#pragma once

#include <modsearch/problem/files.hpp>
#include <modsearch/solvers/meter.hpp>
#include <modsearch/study/page.hpp>
#include <optional>
#include <vector>

namespace modsearch {

/// What the page shows beside the solution itself.
struct PageContext {
  std::optional<Path> path{};  ///< the motion to animate; without it the posture stands still that first misses
                               ///< something, else the first goal's
  std::optional<Sampling> sampling{};
  std::vector<TracePoint> trace{};
  std::string command{};
  std::string reason{};  ///< why it is not achieved or not verified
};

/// The 3-D page of a solution of `problem`. Of a design that is not achieved it says beside each goal by what it is
/// missed (nearest_miss), and marks what touches in the posture that is shown.
[[nodiscard]] Page page_of_solution(const RobotProblem& problem, const SolutionRecord& record,
                                    const PageContext& context);

}  // namespace modsearch
