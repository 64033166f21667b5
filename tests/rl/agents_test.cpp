#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/rl/agents.hpp>
#include <modsearch/rl/training.hpp>

#include "rl/toy_environments.hpp"

namespace modsearch {
namespace {

using testing::CorridorEnvironment;
using testing::IdentityEnvironment;

// Small networks and quick rates: the tasks are small.
AgentOptions quick_agent() {
  return {.gamma = 0.9,
          .value_hidden = {64},
          .actor_hidden = {64},
          .value_rate = 3e-3,
          .actor_rate = 1e-3,
          .value_tau = 0.05,
          .actor_tau = 0.05};
}

TrainingOptions quick_training(std::int64_t episodes) {
  return {.episodes = episodes,
          .batch = 64,
          .warm_up = 64,
          .exploration = {.last_epsilon = 0.1, .epsilon_episodes = episodes / 2},
          .evaluate_every = 100,
          .patience = 0,
          .decay_from = 0.5,
          .decay_to = 0.1};
}

std::vector<std::byte> everything(Agent& agent) {
  std::vector<std::byte> bytes;
  for (const StatePart& part : agent.state()) bytes.insert(bytes.end(), part.bytes.begin(), part.bytes.end());
  return bytes;
}

class EveryAgent : public ::testing::TestWithParam<AgentKind> {
 protected:
  [[nodiscard]] static std::unique_ptr<Agent> make(const Environment& environment, const AgentOptions& options,
                                                   std::uint64_t seed = 0) {
    return make_agent(GetParam(), environment.space(), environment.observation_size(), options, Rng{seed});
  }
};

std::string kind_name(const ::testing::TestParamInfo<AgentKind>& info) { return std::string{name(info.param)}; }

INSTANTIATE_TEST_SUITE_P(Kinds, EveryAgent, ::testing::ValuesIn(agent_kinds().begin(), agent_kinds().end()), kind_name);

TEST_P(EveryAgent, SolvesTheIdentityTask) {
  const IdentityEnvironment environment;
  const auto agent = make(environment, quick_agent());
  Trainer trainer{*agent, environment, quick_training(4000), Rng{1}};
  trainer.run();
  // Random actions earn (1 / 3) (1 - E|x - x*|), about 0.15; DQN's 11 bins are 0.2 apart, which costs 0.05 on average.
  EXPECT_GT(trainer.evaluate("test", 0, 200).mean_return, 0.9);
}

TEST_P(EveryAgent, LearnsToWalkAndRespectsMasks) {
  const CorridorEnvironment environment;
  const auto agent = make(environment, quick_agent());
  Trainer trainer{*agent, environment, quick_training(1500), Rng{1}};
  trainer.run();
  const EvaluationSummary summary = trainer.evaluate("test", 0, 1);
  EXPECT_GT(summary.mean_return, 0.45);  // 0.6 in four steps at full stride; five steps are 0.5
  EXPECT_EQ(summary.success_share, 1.0);
}

TEST_P(EveryAgent, TrainsToTheSameBitsTwice) {
  const IdentityEnvironment environment;
  const auto first = make(environment, quick_agent());
  const auto second = make(environment, quick_agent());
  Trainer{*first, environment, quick_training(300), Rng{1}}.run();
  Trainer{*second, environment, quick_training(300), Rng{1}}.run();
  EXPECT_EQ(everything(*first), everything(*second));
  const auto other = make(environment, quick_agent());
  Trainer{*other, environment, quick_training(300), Rng{2}}.run();
  EXPECT_NE(everything(*first), everything(*other));
}

TEST_P(EveryAgent, ChoosesOnlyWhatIsAllowed) {
  const IdentityEnvironment environment;
  const auto agent = make(environment, quick_agent());
  Rng rng{3};
  for (int i = 0; i < 200; ++i) {
    Eigen::VectorXf s(4);
    for (float& value : s) value = static_cast<float>(rng.uniform(-1.0, 1.0));
    const ActionMask mask = 1 + static_cast<ActionMask>(rng.index(7));
    EXPECT_TRUE(mask >> agent->greedy(s, mask).k & 1);
    const HybridAction random = agent->random(mask, rng);
    EXPECT_TRUE(mask >> random.k & 1);
    EXPECT_LE(random.x.cwiseAbs().maxCoeff(), 1.0F);
  }
  EXPECT_THROW(static_cast<void>(agent->greedy(Eigen::VectorXf::Zero(4), 0)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(agent->greedy(Eigen::VectorXf::Zero(5), 7)), std::invalid_argument);
}

TEST_P(EveryAgent, RandomActionsCoverTypesAndRanges) {
  const IdentityEnvironment environment;
  const auto agent = make(environment, quick_agent());
  Rng rng{4};
  std::array<int, 3> types{};
  float least = 1.0F, most = -1.0F;
  for (int i = 0; i < 3000; ++i) {
    const HybridAction action = agent->random(environment.space().all(), rng);
    ++types[static_cast<std::size_t>(action.k)];
    least = std::min(least, action.x[action.k]);
    most = std::max(most, action.x[action.k]);
  }
  // 1000 expected of each; 5 standard deviations of a binomial are 129.
  for (const int count : types) EXPECT_NEAR(count, 1000, 130);
  EXPECT_LT(least, -0.99F);
  EXPECT_GT(most, 0.99F);
}

TEST_P(EveryAgent, LearnsWithTd3) {
  AgentOptions options = quick_agent();
  options.td3 = {.twin = true, .delay = 2, .smoothing = 0.1, .smoothing_clip = 0.3};
  const IdentityEnvironment environment;
  const auto agent = make(environment, options);
  Trainer trainer{*agent, environment, quick_training(4000), Rng{1}};
  trainer.run();
  EXPECT_GT(trainer.evaluate("test", 0, 200).mean_return, 0.85);
}

// Every weighting of the actor's objective still climbs.
class EveryWeighting : public ::testing::TestWithParam<ActorWeighting> {};
INSTANTIATE_TEST_SUITE_P(Weightings, EveryWeighting,
                         ::testing::Values(ActorWeighting::kSum, ActorWeighting::kWeighted, ActorWeighting::kAverage,
                                           ActorWeighting::kRandom));

TEST_P(EveryWeighting, SolvesTheIdentityTask) {
  for (const bool indexed : {false, true}) {
    AgentOptions options = quick_agent();
    options.weighting = GetParam();
    options.indexed = indexed;
    options.zero_index_gradients = indexed;
    options.actor_rate = 3e-3;  // the weights are small numbers
    const IdentityEnvironment environment;
    const auto agent = make_agent(AgentKind::kMpdqn, environment.space(), 4, options, Rng{0});
    Trainer trainer{*agent, environment, quick_training(4000), Rng{1}};
    trainer.run();
    EXPECT_GT(trainer.evaluate("test", 0, 200).mean_return, 0.85) << "indexed: " << indexed;
  }
}

TEST(Passthrough, IsAddedToTheParametersAndNeverLearns) {
  AgentOptions options = quick_agent();
  options.passthrough_bias = {-0.5, 0.25, 0.75};
  const IdentityEnvironment environment;
  const auto agent = make_agent(AgentKind::kPdqn, environment.space(), 4, options, Rng{0});
  // The actor's own output begins within 1e-4 * |hidden| of 0.
  const HybridAction action = agent->greedy(Eigen::VectorXf::Constant(4, 0.5F), 7);
  EXPECT_TRUE(action.x.isApprox(Eigen::Vector3f(-0.5F, 0.25F, 0.75F), 1e-2F));
  Trainer{*agent, environment, quick_training(200), Rng{1}}.run();
  for (const StatePart& part : agent->state()) {
    if (part.name != "mu.passthrough") continue;
    const auto* numbers = reinterpret_cast<const float*>(part.bytes.data());
    const std::size_t n = part.bytes.size() / sizeof(float);
    EXPECT_EQ(numbers[n - 3], -0.5F);
    EXPECT_EQ(numbers[n - 2], 0.25F);
    EXPECT_EQ(numbers[n - 1], 0.75F);
  }
}

TEST(Parameters, AreStoredAsProposedWhereNotClipped) {
  AgentOptions options = quick_agent();
  options.passthrough_bias = {-3.0, 0.25, 2.0};
  const IdentityEnvironment environment;
  const Eigen::VectorXf s = Eigen::VectorXf::Constant(4, 0.5F);
  // The actor's own output begins within 1e-4 * |hidden| of 0.
  const auto greedy = [&](AgentKind kind) {
    return make_agent(kind, environment.space(), 4, options, Rng{0})->greedy(s, 7).x;
  };
  for (const AgentKind kind : {AgentKind::kPdqn, AgentKind::kMpdqn, AgentKind::kSpdqn, AgentKind::kPaddpg}) {
    options.clip_parameters = true;
    EXPECT_TRUE(greedy(kind).isApprox(Eigen::Vector3f(-1.0F, 0.25F, 1.0F), 1e-2F));
    options.clip_parameters = false;
    EXPECT_TRUE(greedy(kind).isApprox(Eigen::Vector3f(-3.0F, 0.25F, 2.0F), 1e-2F));
  }
}

TEST(Average, ActsByTheSlowlyFollowingActor) {
  // With tau = 1 the mean follows at once, with tau = 0 never: it keeps the parameters that it began with.
  const auto parameters = [](bool average, double tau) {
    AgentOptions options = quick_agent();
    options.average = average;
    options.actor_tau = tau;
    const IdentityEnvironment environment;
    const auto agent = make_agent(AgentKind::kPdqn, environment.space(), 4, options, Rng{0});
    TrainingOptions training = quick_training(200);
    training.exploration.last_epsilon = 1.0;  // so that both see the same episodes
    Trainer{*agent, environment, training, Rng{1}}.run();
    return Eigen::VectorXf{agent->greedy(Eigen::VectorXf::Constant(4, 0.5F), 7).x};
  };
  EXPECT_TRUE(parameters(true, 1.0).isApprox(parameters(false, 1.0), 1e-4F));
  EXPECT_NE(parameters(true, 0.0), parameters(false, 0.0));
  EXPECT_LT(parameters(true, 0.0).norm(), 0.01F);
}

TEST(MakeAgent, RefusesOptionsOutOfRange) {
  const HybridSpace space{{1}};
  const auto refused = [&](const AgentOptions& options) {
    EXPECT_THROW(static_cast<void>(make_agent(AgentKind::kPdqn, space, 1, options, Rng{0})), std::invalid_argument);
  };
  refused({.gamma = 1.5});
  refused({.value_rate = 0.0});
  refused({.value_tau = 7.0});
  refused({.value_hidden = {64, 0}});
  refused({.actor_hidden = {1'000'000}});
  refused({.bound = 0.5});
  refused({.td3 = {.delay = 0}});
  refused({.passthrough_rate = -1e-3});
  refused({.model = {.pull_width = 0.0}});
  refused({.model = {.pull_aim = 1.5}});
  refused({.model = {.pull_steps = 0}});
}

TEST(Dqn, NumbersItsActionsOneToOne) {
  const HybridSpace space{{1, 2, 0}};
  AgentOptions options = quick_agent();
  options.bins = 5;
  const auto agent = make_agent(AgentKind::kDqn, space, 2, options, Rng{0});
  Rng rng{5};
  for (int i = 0; i < 200; ++i) {
    const HybridAction action = agent->random(space.all(), rng);
    float number = -1.0F;
    agent->remember(action, {&number, 1});
    EXPECT_GE(number, 0.0F);
    EXPECT_LT(number, 5 + 25 + 1);
    // Recovered from the values alone: k = 1 begins at 5, k = 2 is 30.
    const auto bin = [&](int j) { return std::lround((action.x[j] + 1.0F) * 2.0F); };
    const long expected = action.k == 0 ? bin(0) : action.k == 1 ? 5 + bin(1) + 5 * bin(2) : 30;
    EXPECT_EQ(std::lround(number), expected);
  }
  options.bins = 1000;
  EXPECT_THROW(make_agent(AgentKind::kDqn, space, 2, options, Rng{0}), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
