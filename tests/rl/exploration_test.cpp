#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/rl/agents.hpp>
#include <modsearch/rl/exploration.hpp>

namespace modsearch {
namespace {

std::unique_ptr<Agent> any_agent() { return make_agent(AgentKind::kPdqn, HybridSpace{{1, 1}}, 1, {}, Rng{0}); }

TEST(Exploration, LetsEpsilonFallLinearlyInEpisodes) {
  const Exploration exploration{{.first_epsilon = 1.0, .last_epsilon = 0.2, .epsilon_episodes = 100}, 2};
  EXPECT_DOUBLE_EQ(exploration.epsilon(0), 1.0);
  EXPECT_DOUBLE_EQ(exploration.epsilon(50), 0.6);
  EXPECT_DOUBLE_EQ(exploration.epsilon(100), 0.2);
  EXPECT_DOUBLE_EQ(exploration.epsilon(5000), 0.2);
}

TEST(Exploration, IsGreedyWithoutEpsilonAndNoise) {
  const auto agent = any_agent();
  Exploration exploration{{.last_epsilon = 0.0, .epsilon_episodes = 1}, 2};
  const Eigen::VectorXf s = Eigen::VectorXf::Constant(1, 0.3F);
  const HybridAction greedy = agent->greedy(s, 3);
  Rng rng{0};
  const HybridAction action = exploration.act(*agent, s, 3, 10, rng);
  EXPECT_EQ(action.k, greedy.k);
  EXPECT_EQ(action.x, greedy.x);
}

// Deviation and correlation of successive noises on the chosen parameter.
std::pair<double, double> statistics(NoiseKind kind) {
  const auto agent = any_agent();
  Exploration exploration{{.last_epsilon = 0.0, .epsilon_episodes = 1, .noise = kind, .deviation = 0.1, .theta = 0.15},
                          2};
  const Eigen::VectorXf s = Eigen::VectorXf::Constant(1, 0.3F);
  const HybridAction greedy = agent->greedy(s, 1);
  Rng rng{0};
  double previous = 0.0, squares = 0.0, products = 0.0;
  constexpr int kDraws = 40'000;
  for (int i = 0; i < kDraws; ++i) {
    const double noise = exploration.act(*agent, s, 1, 10, rng).x[0] - greedy.x[0];
    squares += noise * noise;
    products += noise * previous;
    previous = noise;
  }
  return {std::sqrt(squares / kDraws), products / squares};
}

TEST(Exploration, ReallyExploresWithEitherNoise) {
  const auto [gaussian, no_correlation] = statistics(NoiseKind::kGaussian);
  EXPECT_NEAR(gaussian, 0.1, 0.002);
  EXPECT_NEAR(no_correlation, 0.0, 0.02);
  // The same stationary deviation, correlated by 1 - theta.
  const auto [ou, correlation] = statistics(NoiseKind::kOrnsteinUhlenbeck);
  EXPECT_NEAR(ou, 0.1, 0.005);
  EXPECT_NEAR(correlation, 0.85, 0.01);
}

TEST(Exploration, RefusesSharesOutsideTheUnitInterval) {
  EXPECT_THROW((Exploration{{.first_epsilon = 1.5}, 2}), std::invalid_argument);
  EXPECT_THROW((Exploration{{.last_epsilon = -0.1}, 2}), std::invalid_argument);
  EXPECT_THROW((Exploration{{.theta = 0.0}, 2}), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
