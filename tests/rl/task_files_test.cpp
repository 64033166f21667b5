#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/rl/learner.hpp>

#include "places.hpp"

namespace modsearch {
namespace {

// One file per kind of task: an agent trains on it and its policy answers with a design that is worth what it says.
class EveryTaskFileForAgents : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Kinds, EveryTaskFileForAgents,
                         ::testing::Values("follow", "cycle", "any_order", "payload", "placed_base", "moving"),
                         [](const auto& kind) { return std::string{kind.param}; });

TEST_P(EveryTaskFileForAgents, TrainsAnAgent) {
  const std::string file = (test::source_folder() / "examples/tasks" / (std::string{GetParam()} + ".json")).string();
  const ProblemFile family = load_problem_file(file);
  LearnerSettings settings = settings_of(AgentKind::kMpdqn, Preset::kBest, traits_of(family));
  settings.agent.value_hidden = {32};
  settings.agent.actor_hidden = {32};
  settings.training.episodes = 120;
  settings.training.evaluate_every = 30;
  settings.training.evaluation_episodes = 1;
  settings.training.final_episodes = 1;
  Meter meter{}, use{};
  const Training training = AgentLearner{settings}.train(problem_source(family), meter, Rng{0});
  const auto problem = family.instance();
  const Solution solution = training.policy->solve(*problem, use, Rng{0});
  EXPECT_EQ(problem->evaluate(solution.design).score, solution.evaluation.score);
  std::cout << "    " << to_string(problem->library(), solution.design) << ' ' << solution.evaluation.score << ' '
            << name(solution.evaluation.attempt.why) << '\n';
}

}  // namespace
}  // namespace modsearch
