#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/rl/agents.hpp>
#include <modsearch/rl/design_environment.hpp>
#include <modsearch/rl/training.hpp>
#include <modsearch/solvers/archive.hpp>

#include "problem/temporary_folder.hpp"
#include "rl/toy_environments.hpp"

namespace modsearch {
namespace {

using test::TemporaryFolder;
using testing::CorridorEnvironment;
using testing::IdentityEnvironment;

TrainingOptions short_training(std::int64_t episodes) {
  return {
      .episodes = episodes,
      .batch = 32,
      .warm_up = 32,
      .exploration = {.last_epsilon = 0.1, .epsilon_episodes = episodes / 2, .noise = NoiseKind::kOrnsteinUhlenbeck},
      .evaluate_every = 10,
      .evaluation_episodes = 3,
      .patience = 0,
      .decay_from = 0.5,
      .decay_to = 0.1,
      .elite_share = 0.25,
      .elite_episodes = 8,
      .keep_best = true};
}

std::unique_ptr<Agent> make(const Environment& environment, AgentKind kind = AgentKind::kMpdqn) {
  const AgentOptions options{
      .value_hidden = {16}, .actor_hidden = {16}, .passthrough_rate = 1e-3, .td3 = {.twin = true, .smoothing = 0.1}};
  return make_agent(kind, environment.space(), environment.observation_size(), options, Rng{0});
}

std::vector<std::byte> memory_of(Agent& agent) {
  std::vector<std::byte> bytes;
  for (const StatePart& part : agent.state()) bytes.insert(bytes.end(), part.bytes.begin(), part.bytes.end());
  return bytes;
}

// Everything but the seconds, which are the machine's.
std::vector<double> numbers_of(const std::vector<EvaluationPoint>& history) {
  std::vector<double> numbers;
  for (const EvaluationPoint& p : history) {
    numbers.insert(numbers.end(),
                   {static_cast<double>(p.episode), static_cast<double>(p.steps), static_cast<double>(p.updates),
                    p.epsilon, p.training_return, p.value_loss, p.evaluation.mean_return, p.evaluation.deviation,
                    p.evaluation.success_share, p.evaluation.one_step_share, p.evaluation.mean_steps});
  }
  return numbers;
}

class ResumedTraining : public ::testing::TestWithParam<AgentKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, ResumedTraining, ::testing::ValuesIn(agent_kinds().begin(), agent_kinds().end()),
                         [](const auto& kind) { return std::string{name(kind.param)}; });

TEST_P(ResumedTraining, EndsAsIfItHadNeverStopped) {
  const CorridorEnvironment environment;
  const auto whole = make(environment, GetParam());
  Trainer uninterrupted{*whole, environment, short_training(120), Rng{1}};
  uninterrupted.run();

  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "checkpoint.bin";
  {
    const auto killed = make(environment, GetParam());
    Trainer trainer{*killed, environment, short_training(120), Rng{1}};
    EXPECT_EQ(trainer.run({}, [&] { return trainer.episode() == 57; }), TrainingEnd::kInterrupted);
    Archive archive;
    trainer.save(archive);
    archive.save(file);
  }
  const auto other = make(environment, GetParam());
  Trainer resumed{*other, environment, short_training(120), Rng{1}};
  resumed.load(Archive::load(file));
  EXPECT_EQ(resumed.episode(), 57);
  EXPECT_EQ(resumed.run(), TrainingEnd::kEpisodes);
  EXPECT_EQ(memory_of(*other), memory_of(*whole));
  EXPECT_EQ(numbers_of(resumed.history()), numbers_of(uninterrupted.history()));
}

TEST(Trainer, RefusesTheCheckpointOfAnotherAgent) {
  const CorridorEnvironment environment;
  const auto agent = make(environment);
  Archive archive;
  Trainer{*agent, environment, short_training(10), Rng{1}}.save(archive);
  const auto other = make(environment, AgentKind::kDqn);
  Trainer trainer{*other, environment, short_training(10), Rng{1}};
  EXPECT_THROW(trainer.load(archive), FileError);
}

TEST(Trainer, EvaluatesAfterEveryNthEpisodeAndCountsWhatItDoes) {
  const CorridorEnvironment environment;
  const auto agent = make(environment);
  Trainer trainer{*agent, environment, short_training(45), Rng{1}};
  trainer.run();
  ASSERT_EQ(trainer.history().size(), 4U);  // after 10, 20, 30, 40
  EXPECT_EQ(trainer.history()[2].episode, 30);
  EXPECT_EQ(trainer.episode(), 45);
  EXPECT_GE(trainer.steps(), 4 * 45);                  // no episode is shorter than four strides
  EXPECT_LE(trainer.steps(), 10 * 45);                 // or longer than ten
  EXPECT_EQ(trainer.updates(), trainer.steps() - 31);  // one per step, the first with the 32nd experience
}

TEST(Trainer, EndsWhenPatienceIsOver) {
  const CorridorEnvironment environment;
  const auto agent = make(environment);
  TrainingOptions options = short_training(100'000);
  options.patience = 5;
  Trainer trainer{*agent, environment, options, Rng{1}};
  EXPECT_EQ(trainer.run(), TrainingEnd::kPatience);
  const auto& history = trainer.history();
  ASSERT_GT(history.size(), 5U);
  double before = history.front().evaluation.mean_return;
  for (std::size_t i = 0; i + 5 < history.size(); ++i) before = std::max(before, history[i].evaluation.mean_return);
  for (std::size_t i = history.size() - 5; i < history.size(); ++i) {
    EXPECT_LE(history[i].evaluation.mean_return, before);
  }
}

TEST(Trainer, EndsWhenTheObserverSaysSo) {
  const CorridorEnvironment environment;
  const auto agent = make(environment);
  Trainer trainer{*agent, environment, short_training(1000), Rng{1}};
  EXPECT_EQ(trainer.run([](const Trainer& t) { return t.history().size() < 3; }), TrainingEnd::kInterrupted);
  EXPECT_EQ(trainer.episode(), 30);
}

TEST(Trainer, KeepsThePolicyOfItsBestEvaluation) {
  const IdentityEnvironment environment;
  const auto agent = make(environment);
  Trainer trainer{*agent, environment, short_training(200), Rng{1}};
  std::size_t best = 0;
  trainer.run();
  trainer.use_best_policy();
  for (std::size_t i = 1; i < trainer.history().size(); ++i) {
    if (trainer.history()[i].evaluation.mean_return > trainer.history()[best].evaluation.mean_return) best = i;
  }
  // Evaluation number i uses episodes 3 i, 3 i + 1, 3 i + 2 of its stream.
  EXPECT_EQ(trainer.evaluate("evaluation", 3 * static_cast<std::int64_t>(best), 3).mean_return,
            trainer.history()[best].evaluation.mean_return);
}

TEST(Trainer, RefusesOptionsOutOfRangeAndAgentsThatDoNotFit) {
  const CorridorEnvironment corridor;
  const IdentityEnvironment identity;
  const auto agent = make(corridor);
  EXPECT_THROW((Trainer{*agent, identity, short_training(10), Rng{1}}), std::invalid_argument);
  TrainingOptions options = short_training(10);
  options.batch = 0;
  EXPECT_THROW((Trainer{*agent, corridor, options, Rng{1}}), std::invalid_argument);
  options = short_training(10);
  options.acting.polish = -1;
  EXPECT_THROW((Trainer{*agent, corridor, options, Rng{1}}), std::invalid_argument);
  options = short_training(10);
  options.decay_to = 0.0;
  EXPECT_THROW((Trainer{*agent, corridor, options, Rng{1}}), std::invalid_argument);
}

TEST(Trainer, EndsWhenTheNumbersLeaveAllBounds) {
  const IdentityEnvironment environment;
  const auto agent = make_agent(AgentKind::kPdqn, environment.space(), environment.observation_size(),
                                {.value_hidden = {16}, .actor_hidden = {16}, .value_rate = 1e30}, Rng{0});
  TrainingOptions options = short_training(1000);
  options.elite_share = 0.0;
  Trainer trainer{*agent, environment, options, Rng{1}};
  EXPECT_EQ(trainer.run(), TrainingEnd::kDiverged);
  EXPECT_LT(trainer.episode(), 200);
}

TEST(StabilisedAfter, IsTheFirstOfTenEvaluationsInOneStepInARow) {
  std::vector<EvaluationPoint> history(25);
  for (std::size_t i = 0; i < history.size(); ++i) {
    history[i].episode = 30 * static_cast<std::int64_t>(i + 1);
    history[i].evaluation.one_step_share = i == 8 ? 0.9 : 1.0;
  }
  EXPECT_EQ(stabilised_after(history), 300);  // the row of eight before the ninth point is too short
  history[15].evaluation.one_step_share = 0.0;
  EXPECT_EQ(stabilised_after(history), std::nullopt);
}

TEST(Trainer, LearnsNothingFromAStepThatTheBudgetDidNotPay) {
  DesignEnvironment environment{load_problem_file("seed/fixed"), {}};
  int left = 2;
  environment.set_evaluate([&](const DesignProblem&, const Design&, Fidelity) -> std::optional<Evaluation> {
    if (left-- == 0) return std::nullopt;
    Evaluation evaluation;
    evaluation.score = 1.0;
    return evaluation;
  });
  const auto agent = make(environment);
  TrainingOptions options = short_training(1);
  options.batch = options.warm_up = 1;
  Trainer trainer{*agent, environment, options, Rng{1}};
  trainer.run();
  EXPECT_EQ(trainer.steps(), 2);
  EXPECT_EQ(trainer.updates(), 2);  // one per experience
}

}  // namespace
}  // namespace modsearch
