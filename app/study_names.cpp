#include "app/study_names.hpp"

#include "app/agent_choice.hpp"
#include "app/name_and_options.hpp"
#include "app/solver_registry.hpp"

namespace modsearch::app {

StudyNames study_names() {
  return {.solver = [](const std::string& text) -> StudyNames::NamedSolver {
            ChosenSolver chosen = choose_solver(text);
            return {canonical({chosen.name, chosen.options}), std::move(chosen.solver)};
          },
          .agent = [](const std::string& text, const ProblemFile& problem) -> StudyNames::NamedAgent {
            ChosenAgent chosen = choose_agent(text, problem);
            return {std::move(chosen.text), std::move(chosen.preset), std::move(chosen.settings)};
          }};
}

}  // namespace modsearch::app
