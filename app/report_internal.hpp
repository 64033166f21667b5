#pragma once

#include <modsearch/problem/files.hpp>
#include <modsearch/problem/nearest_miss.hpp>
#include <modsearch/solvers/solver.hpp>
#include <modsearch/solvers/verification.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace modsearch::app {

/// "achieved", or how far it got and why no farther.
[[nodiscard]] std::string standing(const Attempt& attempt);

/// The facts of an evaluated design, as JSON with flat keys; where it is not achieved, "misses" says by what.
[[nodiscard]] nlohmann::ordered_json evaluation_json(const RobotProblem& problem, const Design& design,
                                                     const Evaluation& evaluation);
/// The same for people: the design, called `label`, the score term by term, what was reached, and what was missed.
[[nodiscard]] std::string evaluation_text(const RobotProblem& problem, const Design& design,
                                          const Evaluation& evaluation, std::string_view label = "design");

/// What keeps a design from being achieved, one object per miss.
[[nodiscard]] nlohmann::ordered_json misses_json(const RobotProblem& problem, const Design& design,
                                                 const NearestMiss& missed);

/// The outcome of verifying `design`; where it is not achieved at level path, by what it misses that.
[[nodiscard]] nlohmann::ordered_json verification_json(const RobotProblem& problem, const Design& design,
                                                       const Verification& verification);
[[nodiscard]] std::string verification_text(const RobotProblem& problem, const Design& design,
                                            const Verification& verification);

/// Why no design is achieved: reason, and goal, obstacle, module and depth where the proof is about these.
[[nodiscard]] nlohmann::ordered_json infeasibility_json(const Infeasibility& infeasibility);
/// A line about where the motion begins, where that is neither what the task says nor all joints at 0; else nothing.
[[nodiscard]] std::string home_text(const RobotProblem& problem, const std::optional<Path>& path);

/// The trace of a search as CSV with a header.
[[nodiscard]] std::string trace_csv(const std::vector<TracePoint>& trace);

/// How many evaluations were achieved and why the others were not: "achieved" and names of failures, those that
/// occurred.
[[nodiscard]] nlohmann::ordered_json outcomes_json(const Progress& spent);
[[nodiscard]] std::string outcomes_text(const Progress& spent);
/// Why evaluations were not achieved, at most `most` reasons, the most frequent first: "812 unreachable, 40 obstacle".
/// Empty: all were achieved.
[[nodiscard]] std::string failures_text(const Progress& spent, std::size_t most);

}  // namespace modsearch::app
