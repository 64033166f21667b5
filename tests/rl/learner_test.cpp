#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/rl/learner.hpp>
#include <modsearch/rl/saved_policy.hpp>
#include <modsearch/solvers/archive.hpp>

#include "contracts/learner_contract.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

LearnerSettings short_settings(AgentKind kind) {
  LearnerSettings settings = settings_of(kind, Preset::kBest);
  settings.agent.value_hidden = {32};
  settings.agent.actor_hidden = {32};
  settings.training.episodes = 90;
  settings.training.final_episodes = 5;
  settings.training.evaluation_episodes = 1;
  settings.training.evaluate_every = 30;
  return settings;
}

class EveryLearner : public ::testing::TestWithParam<AgentKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, EveryLearner, ::testing::ValuesIn(agent_kinds().begin(), agent_kinds().end()),
                         [](const auto& kind) { return std::string{name(kind.param)}; });

TEST_P(EveryLearner, KeepsTheContractOfLearners) {
  for (const char* id : {"seed/fixed", "seed/random_obstacles"}) {
    const ProblemFile file = load_problem_file(id);
    testing::expect_learner_contract(AgentLearner{short_settings(GetParam())}, problem_source(file),
                                     *file.instance({3, 4}));
  }
}

TEST_P(EveryLearner, KeepsItsPolicyInAFile) {
  const ProblemFile file = load_problem_file("seed/random_narrow");
  Meter meter{};
  const Training training = AgentLearner{short_settings(GetParam())}.train(problem_source(file), meter, Rng{5});
  const auto& policy = dynamic_cast<const Policy&>(*training.policy);
  const test::TemporaryFolder folder;
  write_policy(folder.path() / "policy.json",
               describe(policy, *file.spec.library, "seed/random_narrow", {.version = "test", .preset = "best"}));
  const std::unique_ptr<Policy> read = load_trained_policy(folder.path() / "policy.json");
  for (std::uint64_t i = 0; i < 20; ++i) {
    const auto problem = file.instance({7, i});
    Meter first{}, second{};
    EXPECT_EQ(read->solve(*problem, second, Rng{0}).design, policy.solve(*problem, first, Rng{0}).design);
  }
}

TEST(AgentLearner, KeepsTheWhiteningOfItsObservationsWithThePolicy) {
  const ProblemFile file = load_problem_file("seed/random_narrow");
  LearnerSettings settings = short_settings(AgentKind::kMpdqn);
  settings.environment.whiten = 200;
  Meter meter{};
  const Training training = AgentLearner{settings}.train(problem_source(file), meter, Rng{5});
  const auto& policy = dynamic_cast<const Policy&>(*training.policy);
  EXPECT_FALSE(policy.settings().environment.encoder.whitening.empty());
  const std::unique_ptr<Policy> read =
      revive(describe(policy, *file.spec.library, "seed/random_narrow", {.version = "test"}));
  for (std::uint64_t i = 0; i < 10; ++i) {
    const auto problem = file.instance({7, i});
    Meter first{}, second{};
    EXPECT_EQ(read->solve(*problem, second, Rng{0}).design, policy.solve(*problem, first, Rng{0}).design);
  }
}

TEST(AgentLearner, LearnsOneModuleOnTheFixedProblem) {
  const ProblemFile file = load_problem_file("seed/fixed");
  LearnerSettings settings = settings_of(AgentKind::kMpdqn, Preset::kBest);
  settings.training.final_episodes = 1;
  Meter meter{};
  const Training training = AgentLearner{settings}.train(problem_source(file), meter, Rng{0});
  EXPECT_EQ(training.final_evaluation.one_step_share, 1.0);
  const auto problem = file.instance();
  Meter use{};
  const Solution solution = training.policy->solve(*problem, use, Rng{0});
  EXPECT_TRUE(solution.evaluation.attempt.achieved);
  // Any one module that reaches scores at least 350 - 5 * 3 = 335.
  EXPECT_GE(solution.evaluation.score, 335.0);
  EXPECT_EQ(use.progress().evaluations, 1);
}

TEST(Policy, RefusesProblemsOfAnotherFamily) {
  const ProblemFile narrow = load_problem_file("seed/random_narrow");
  Meter meter{};
  const Training training = AgentLearner{short_settings(AgentKind::kPdqn)}.train(problem_source(narrow), meter, Rng{5});
  const auto other = load_problem("seed/random_obstacles");  // its observations hold the obstacles too
  Meter use{};
  try {
    static_cast<void>(training.policy->solve(*other, use, Rng{0}));
    FAIL() << "accepted";
  } catch (const std::invalid_argument& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("seed/random_obstacles"));
  }
}

TEST(Policy, TakesTheBestOfSeveralProposals) {
  const ProblemFile file = load_problem_file("seed/random_narrow");
  Meter meter{};
  const Training training = AgentLearner{short_settings(AgentKind::kMpdqn)}.train(problem_source(file), meter, Rng{5});
  auto& policy = dynamic_cast<Policy&>(*training.policy);
  ActingOptions one = policy.settings().training.acting;
  ActingOptions several = one;
  several.proposals = 4;
  several.all_types = true;
  for (std::uint64_t i = 0; i < 10; ++i) {
    const auto problem = file.instance({8, i});
    Meter first{}, second{};
    policy.set_acting(one);
    const Solution single = policy.solve(*problem, first, Rng{0});
    policy.set_acting(several);
    const Solution best = policy.solve(*problem, second, Rng{0});
    EXPECT_FALSE(single.evaluation.better_than(best.evaluation));
    EXPECT_GE(second.progress().evaluations, 12);  // four of each of the three types, then the step
  }
}

TEST(SavedPolicy, IsRefusedWithAnUnknownAgentOrSetting) {
  const ProblemFile file = load_problem_file("seed/fixed");
  Meter meter{};
  const Training training = AgentLearner{short_settings(AgentKind::kPdqn)}.train(problem_source(file), meter, Rng{5});
  const PolicyFile good =
      describe(dynamic_cast<const Policy&>(*training.policy), *file.spec.library, "seed/fixed", {.version = "test"});
  EXPECT_NO_THROW(static_cast<void>(revive(good)));
  PolicyFile bad = good;
  bad.agent = "sarsa";
  EXPECT_THROW(static_cast<void>(revive(bad)), std::invalid_argument);
  bad = good;
  bad.settings["gama"] = "0.9";
  EXPECT_THROW(static_cast<void>(revive(bad)), std::invalid_argument);
  bad = good;
  bad.settings["value_hidden"] = "64";  // other weights than the file holds
  EXPECT_THROW(static_cast<void>(revive(bad)), std::invalid_argument);
  bad = good;
  bad.tensors.pop_back();
  EXPECT_THROW(static_cast<void>(revive(bad)), std::invalid_argument);
}

// A training on real problems, with models in the replay, hindsight and noise.
TEST(Checkpoint, LetsATrainingOnDesignsEndAsIfItHadNeverStopped) {
  const ProblemFile file = load_problem_file("seed/random_obstacles");
  LearnerSettings settings = short_settings(AgentKind::kMpdqn);
  settings.agent.model = {.reach = 10.0, .mass = 1.0, .pull = 1.0};
  settings.agent.passthrough_rate = 1e-3;
  settings.training.hindsight = 2;
  settings.training.elite_share = 0.25;
  settings.environment.whiten = 100;
  settings.environment.hindsight_region = file.sampling;
  const auto tensors = [](const Training& t) { return dynamic_cast<const Policy&>(*t.policy).tensors(); };

  Meter meter{};
  const Training whole = AgentLearner{settings}.train(problem_source(file), meter, Rng{1});
  const test::TemporaryFolder folder;
  int episodes = 0;
  const AgentLearner killed{settings,
                            {.begin = {},
                             .observer = {},
                             .stop = [&] { return ++episodes > 41; },
                             .ended =
                                 [&](const Trainer& trainer) {
                                   Archive archive;
                                   trainer.save(archive);
                                   archive.save(folder.path() / "checkpoint.bin");
                                 }}};
  Meter first{};
  EXPECT_EQ(killed.train(problem_source(file), first, Rng{1}).end, TrainingEnd::kInterrupted);
  const AgentLearner resumed{
      settings,
      {.begin = [&](Trainer& trainer) { trainer.load(Archive::load(folder.path() / "checkpoint.bin")); },
       .observer = {},
       .stop = {},
       .ended = {}}};
  Meter second{};
  const Training rest = resumed.train(problem_source(file), second, Rng{1});
  EXPECT_EQ(tensors(rest), tensors(whole));
  EXPECT_EQ(rest.final_evaluation.mean_return, whole.final_evaluation.mean_return);
}

}  // namespace
}  // namespace modsearch
