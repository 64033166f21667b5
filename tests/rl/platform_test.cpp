#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "platform/platform_environment.hpp"

namespace modsearch {
namespace {

using Action = PlatformAction;

/// Sum of 0.99^i over i < n: what drag leaves of a speed that is never renewed.
double decayed(int n) { return (1.0 - std::pow(0.99, n)) / 0.01; }

TEST(PlatformWorld, BeginsAsPublished) {
  const PlatformWorld world{Rng{1}};
  const double expected[] = {0.0190, 0.0, 0.2222, 0.0, 0.9091, 1.0, 0.9574, 0.0, 0.0};
  const auto state = world.scaled_state();
  for (std::size_t i = 0; i < state.size(); ++i)
    EXPECT_NEAR(state[i], expected[i], 5e-5) << i;  // four digits are given
  EXPECT_TRUE(world.grounded());
}

TEST(PlatformWorld, JumpsInAParabolaWithDragWhereThereIsNoNoise) {
  // A hop starts upwards at 35 px/s; n sub-steps later y - 40 = 0.05 (35 n - 0.49 n (n - 1) / 2), above 0 for n = 143
  // (1.5) and below for n = 144 (-0.25). It aims at 720 / 8.14 = 88 px/s, but a push adds no more than 600 * 0.05 = 30.
  PlatformWorld world{Rng{1}, 0.0};
  const PlatformOutcome outcome = world.act(Action::kHop, 720.0);
  EXPECT_EQ(outcome.sub_steps, 144);
  EXPECT_NEAR(world.player().x, 0.05 * 30.0 * decayed(144), 1e-9);
  EXPECT_NEAR(outcome.reward, world.player().x / 1035.0, 1e-15);
  EXPECT_FALSE(outcome.over());
  EXPECT_TRUE(world.grounded());
  EXPECT_EQ(world.player().vx, 0.0);
  EXPECT_EQ(world.player().vy, 0.0);
}

TEST(PlatformWorld, HopsAsFarAsPublished) {
  // Published: at x = 107 after 143 sub-steps, of one noisy hop. Noise shortens the 144 sub-steps by |N(0, 1)| off 35
  // px/s and the way by 143 times |N(0, 0.025)|, so the hops of that duration have to lie about 107.
  int of_143 = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    PlatformWorld world{Rng{seed}};
    const PlatformOutcome outcome = world.act(Action::kHop, 720.0);
    ASSERT_FALSE(outcome.over());
    ASSERT_LE(outcome.sub_steps, 144);
    ASSERT_GE(outcome.sub_steps, 120);  // 5 standard deviations
    if (outcome.sub_steps != 143) continue;
    ++of_143;
    EXPECT_NEAR(world.player().x, 107.5, 1.5);
  }
  // 143 <=> 0.21 < |N| <= 0.455: a share of 0.185
  EXPECT_NEAR(of_143, 0.185 * 500, 30);
}

TEST(PlatformWorld, EndsALeapIntoTheEnemyWherePublished) {
  // Published: leap(400) from rest ends near x = 84 after 86 sub-steps. By then the enemy has come from 230 to about
  // 230 + 1.5 - 85 * 1.5 = 104, where the player's right edge is: it is no landing but a touch.
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    PlatformWorld world{Rng{seed}};
    const PlatformOutcome outcome = world.act(Action::kLeap, 400.0);
    EXPECT_TRUE(outcome.touched);
    EXPECT_NEAR(outcome.sub_steps, 86, 1);
    EXPECT_NEAR(world.player().x, 84.0, 1.0);
    EXPECT_THROW(static_cast<void>(world.act(Action::kRun, 1.0)), std::logic_error);
  }
}

TEST(PlatformWorld, RunsForTwentySubStepsUpToItsTopSpeed) {
  PlatformWorld world{Rng{1}, 0.0};
  EXPECT_EQ(world.act(Action::kRun, 10.0).sub_steps, 20);
  // v <- min(0.99 v + 10, 70), moving 0.05 v
  double v = 0.0, x = 0.0;
  for (int i = 0; i < 20; ++i) {
    v = std::min(0.99 * v + 10.0, 70.0);
    x += 0.05 * v;
  }
  EXPECT_NEAR(world.player().x, x, 1e-9);
  EXPECT_NEAR(world.player().vx, 0.99 * 70.0, 1e-9);
  EXPECT_TRUE(world.grounded());
}

TEST(PlatformWorld, SlowsDownByTheNoiseOfEveryAcceleration) {
  // Running with parameter 0 from rest: noise only ever takes speed away, and there is none to take.
  PlatformWorld world{Rng{1}};
  for (int i = 0; i < 3; ++i) static_cast<void>(world.act(Action::kRun, 0.0));
  EXPECT_EQ(world.player().x, 0.0);
  // At 1 px/s per sub-step, twenty draws of |N(0, 0.025)|, mean 0.0199, cost 0.05 * 0.0199 * sum_{n <= 20} decayed(n).
  double lost = 0.0, with_noise = 0.0, without = 0.0;
  for (int n = 1; n <= 20; ++n) {
    lost += 0.05 * 0.025 * std::sqrt(2.0 / 3.14159265) * decayed(n);
    without += 0.05 * decayed(n);
  }
  constexpr int kRuns = 400;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    PlatformWorld noisy{Rng{seed}};
    static_cast<void>(noisy.act(Action::kRun, 1.0));
    with_noise += noisy.player().x / kRuns;
  }
  EXPECT_NEAR(without - with_noise, lost, 0.01);  // standard error 0.0025
}

TEST(PlatformWorld, ClipsParametersToTheirRange) {
  PlatformWorld far{Rng{1}, 0.0}, farther{Rng{1}, 0.0}, back{Rng{1}, 0.0};
  static_cast<void>(far.act(Action::kRun, 30.0));
  static_cast<void>(farther.act(Action::kRun, 1e9));
  static_cast<void>(back.act(Action::kRun, -5.0));
  EXPECT_EQ(far.player().x, farther.player().x);
  EXPECT_EQ(back.player().x, 0.0);
  EXPECT_THROW(static_cast<void>(far.act(Action::kRun, std::nan(""))), std::invalid_argument);
}

TEST(PlatformWorld, TurnsTheEnemyTwiceAtItsFirstBound) {
  // It starts at its bound: to the right against the bound, then to the left at 1.5 px per sub-step.
  PlatformWorld world{Rng{1}, 0.0};
  static_cast<void>(world.act(Action::kRun, 0.0));
  EXPECT_NEAR(world.enemy(0).x, 230.0 - 19 * 1.5, 1e-9);
  EXPECT_EQ(world.enemy(0).vx, -30.0);
  EXPECT_EQ(world.enemy(1).x, 730.0);  // not on the player's side
  EXPECT_EQ(world.enemy(1).vx, -30.0);
}

TEST(PlatformWorld, TurnsTheEnemyAtTheOtherEndAndTouchesWhoWaitsThere) {
  // 230 px at 1.5 per sub-step lead the enemy to the player's right edge at 20 in 141 sub-steps and two.
  PlatformWorld world{Rng{1}, 0.0};
  int sub_steps = 0;
  PlatformOutcome outcome;
  while (!outcome.over()) {
    outcome = world.act(Action::kRun, 0.0);
    sub_steps += outcome.sub_steps;
  }
  EXPECT_TRUE(outcome.touched);
  EXPECT_EQ(sub_steps, 142);  // 230 - 141 * 1.5 = 18.5 < 20, and one sub-step against the bound
  EXPECT_EQ(outcome.reward, 0.0);
}

TEST(PlatformWorld, FallsIntoTheGapAndKeepsWhatWasGained) {
  PlatformWorld world{Rng{1}, 0.0};
  static_cast<void>(world.act(Action::kRun, 30.0));
  const double start = world.player().x;
  // At 70 px/s and 88 at most: over the enemy and the edge at 250, but not to 455.
  const PlatformOutcome outcome = world.act(Action::kHop, 720.0);
  EXPECT_TRUE(outcome.fallen);
  EXPECT_FALSE(outcome.touched);
  EXPECT_GT(world.player().x, 250.0);
  EXPECT_LT(world.player().x, 455.0);
  EXPECT_LT(world.player().y, 40.0);
  EXPECT_NEAR(outcome.reward, (world.player().x - start) / 1035.0, 1e-15);
}

/// Where a run would end: the noise of each sub-step at its mean.
double end_of_run(double x, double vx, double parameter) {
  for (int i = 0; i < 20; ++i) {
    vx = std::clamp(vx + parameter - 0.02, 0.0, 70.0);
    x += 0.05 * vx;
    vx *= 0.99;
  }
  return x;
}

/// A player who knows the world: over the enemies in the air, up to speed before a gap, and over it with a hop.
std::pair<Action, double> scripted(const PlatformWorld& world) {
  const double x = world.player().x;
  if (x >= 965.0) return {Action::kRun, 30.0};  // nothing but the end is ahead
  const bool first = x < 455.0;
  const double edge = first ? 250.0 : 750.0;
  const bool enemy_ahead = world.enemy(first ? 0 : 1).x > x;
  if (enemy_ahead && first) {
    // From a run of one action at about 40 px/s over the enemy, which comes closer.
    return x < 30.0 ? std::pair{Action::kRun, 30.0} : std::pair{Action::kHop, 320.0};
  }
  if (enemy_ahead) return {Action::kHop, 720.0};
  if (x > edge - 30.0) return {Action::kHop, 720.0};
  double parameter = 0.0;
  while (parameter < 30.0 && end_of_run(x, world.player().vx, parameter + 0.1) < edge - 10.0) parameter += 0.1;
  return {Action::kRun, parameter};
}

TEST(PlatformWorld, LetsAPlayerWhoKnowsItArrive) {
  constexpr int kEpisodes = 300;
  int arrived = 0;
  for (std::uint64_t seed = 0; seed < kEpisodes; ++seed) {
    PlatformWorld world{Rng{seed}};
    double total = 0.0;
    PlatformOutcome outcome;
    while (!outcome.over()) {
      const auto [action, parameter] = scripted(world);
      outcome = world.act(action, parameter);
      total += outcome.reward;
    }
    ASSERT_NEAR(total, world.player().x / 1035.0, 1e-12);
    EXPECT_EQ(outcome.arrived, world.player().x == 1035.0);
    arrived += outcome.arrived ? 1 : 0;
  }
  EXPECT_GE(arrived, kEpisodes * 99 / 100);
}

/// The scaled action of a run, hop or leap.
HybridAction scaled(Action action, double parameter) {
  HybridAction result;
  result.k = static_cast<int>(action);
  result.x = Eigen::VectorXf::Zero(3);
  result.x[result.k] = static_cast<float>(2.0 * parameter / PlatformWorld::largest(action) - 1.0);
  return result;
}

HybridAction scripted_action(const PlatformEnvironment& environment) {
  const auto [action, parameter] = scripted(environment.world());
  return scaled(action, parameter);
}

TEST(PlatformEnvironment, HasThreeActionsOfOneParameter) {
  const PlatformEnvironment environment;
  EXPECT_EQ(environment.name(), "platform");
  EXPECT_EQ(environment.space(), HybridSpace({1, 1, 1}));
  EXPECT_EQ(environment.observation_size(), 9);
}

TEST(PlatformEnvironment, MapsTheScaledStateOnToMinusOneToOne) {
  PlatformEnvironment environment;
  environment.reset(Rng{1});
  const auto state = environment.world().scaled_state();
  ASSERT_EQ(environment.observation().size(), 9);
  for (int i = 0; i < 9; ++i) {
    EXPECT_FLOAT_EQ(environment.observation()[i], static_cast<float>(2.0 * state[static_cast<std::size_t>(i)] - 1.0));
  }
  EXPECT_EQ(environment.mask(), 0b111U);
}

TEST(PlatformEnvironment, StaysWithinItsBoundsAndEndsAsThePlayerDoes) {
  PlatformEnvironment environment;
  Rng draws{11};
  for (std::uint64_t episode = 0; episode < 300; ++episode) {
    environment.reset(Rng{7}.fork(episode));
    double total = 0.0;
    Step step;
    while (environment.running()) {
      // Mostly as one who knows would play, so that all three platforms are seen; the rest at random.
      HybridAction action = scripted_action(environment);
      if (draws.uniform() < 0.2) {
        action.k = draws.index(3);
        for (int i = 0; i < 3; ++i) action.x[i] = static_cast<float>(draws.uniform(-1.5, 1.5));
      }
      step = environment.step(action);
      total += step.reward;
      ASSERT_TRUE(environment.observation().allFinite());
      ASSERT_LE(environment.observation().cwiseAbs().maxCoeff(), 1.0F + 1e-6F);
    }
    EXPECT_TRUE(step.terminated != step.truncated);
    EXPECT_NEAR(total, environment.world().player().x / 1035.0, 1e-12);
    EXPECT_EQ(step.success, environment.world().player().x == 1035.0);
  }
}

TEST(PlatformEnvironment, ScalesParametersToTheirRanges) {
  PlatformEnvironment environment{{.noise = 0.0}};
  environment.reset(Rng{1});
  EXPECT_NEAR(environment.step(scaled(Action::kRun, 10.0)).reward, end_of_run(0.0, 0.0, 10.02) / 1035.0, 1e-6);
}

TEST(PlatformEnvironment, TruncatesAtTheLimitWithoutTerminating) {
  PlatformEnvironment environment;
  environment.reset(Rng{3});
  int actions = 0;
  Step step;
  while (environment.running()) {
    // On the last platform nobody disturbs: wait there.
    const bool last = environment.world().player().x >= 965.0;
    step = environment.step(last ? scaled(Action::kRun, 0.0) : scripted_action(environment));
    ++actions;
  }
  EXPECT_EQ(actions, 200);
  EXPECT_TRUE(step.truncated);
  EXPECT_FALSE(step.terminated);
  EXPECT_FALSE(step.success);
}

TEST(PlatformEnvironment, RepeatsAnEpisodeFromItsStreamAndItsActions) {
  PlatformEnvironment one;
  const std::unique_ptr<Environment> other = one.clone();
  EXPECT_FALSE(other->running());
  one.reset(Rng{5});
  other->reset(Rng{5});
  while (one.running()) {
    const HybridAction action = scripted_action(one);
    EXPECT_EQ(one.step(action).reward, other->step(action).reward);
    EXPECT_EQ(one.observation(), other->observation());
  }
  EXPECT_FALSE(other->running());
}

TEST(PlatformEnvironment, RefusesImpossibleOptions) {
  EXPECT_THROW(PlatformEnvironment({.most_actions = 0}), std::invalid_argument);
  EXPECT_THROW(PlatformEnvironment({.noise = -1.0}), std::invalid_argument);
  EXPECT_THROW(PlatformEnvironment({.noise = std::numeric_limits<double>::quiet_NaN()}), std::invalid_argument);
  const PlatformEnvironment environment;
  EXPECT_THROW(static_cast<void>(environment.world()), std::logic_error);
}

}  // namespace
}  // namespace modsearch
