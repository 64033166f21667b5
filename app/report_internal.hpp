#pragma once

#include <modsearch/problem/files.hpp>
#include <modsearch/solvers/solver.hpp>
#include <modsearch/solvers/verification.hpp>
#include <nlohmann/json.hpp>
#include <string>

namespace modsearch::app {

/// The facts of an evaluated design, as JSON with flat keys.
[[nodiscard]] nlohmann::ordered_json evaluation_json(const RobotProblem& problem, const Design& design,
                                                     const Evaluation& evaluation);
/// The same for people: the design, the score term by term, and what was reached.
[[nodiscard]] std::string evaluation_text(const RobotProblem& problem, const Design& design,
                                          const Evaluation& evaluation);

/// The outcome of a verification.
[[nodiscard]] nlohmann::ordered_json verification_json(const Verification& verification);
[[nodiscard]] std::string verification_text(const Verification& verification);
/// A line about where the motion begins, where that is neither what the task says nor all joints at 0; else nothing.
[[nodiscard]] std::string home_text(const RobotProblem& problem, const std::optional<Path>& path);

/// The trace of a search as CSV with a header.
[[nodiscard]] std::string trace_csv(const std::vector<TracePoint>& trace);

/// How many evaluations were achieved and why the others were not: "achieved" and names of failures, those that
/// occurred.
[[nodiscard]] nlohmann::ordered_json outcomes_json(const Progress& spent);
[[nodiscard]] std::string outcomes_text(const Progress& spent);

}  // namespace modsearch::app
