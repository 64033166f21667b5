#include <fmt/format.h>

#include <modsearch/study/environment_page.hpp>
#include <modsearch/study/solution_page.hpp>
#include <stdexcept>

namespace modsearch {

std::string render(const DesignEnvironment& environment) {
  const auto* problem = dynamic_cast<const RobotProblem*>(&environment.problem());
  if (problem == nullptr) {
    throw std::invalid_argument(
        fmt::format("render: '{}' is no robot problem, there is nothing to draw", environment.problem().name()));
  }
  SolutionRecord record;
  record.problem = problem->name();
  record.design = environment.design();
  record.X_WB = problem->spec().X_WB;
  record.evaluation = environment.evaluation().value_or(problem->evaluate(record.design, Fidelity::kScreen));
  const Attempt& attempt = record.evaluation.attempt;
  return write_page(page_of_solution(
      *problem, record,
      {.path = attempt.path, .reason = attempt.achieved ? std::string{} : std::string{name(attempt.why)}}));
}

}  // namespace modsearch
