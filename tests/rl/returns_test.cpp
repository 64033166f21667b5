#include <gtest/gtest.h>

#include <modsearch/rl/agents.hpp>
#include <modsearch/rl/returns.hpp>

namespace modsearch {
namespace {

const HybridSpace kSpace{{1}};

std::unique_ptr<Agent> any_agent() { return make_agent(AgentKind::kPdqn, kSpace, 1, {.gamma = 0.5}, Rng{0}); }

Transition step(float s, float reward, bool terminated = false, bool truncated = false) {
  Transition t;
  t.s = Eigen::VectorXf::Constant(1, s);
  t.action.x = Eigen::VectorXf::Constant(1, s / 10.0F);
  t.reward = reward;
  t.s_next = Eigen::VectorXf::Constant(1, s + 1.0F);
  t.next_mask = 1;
  t.terminated = terminated;
  t.truncated = truncated;
  return t;
}

TEST(Returns, OfOneStepAreKnownAtOnce) {
  const auto agent = any_agent();
  Returns returns{{.reward_scale = 0.1}, 0.5};
  const std::vector<Experience> ready = returns.add(*agent, step(0.0F, 20.0F));
  ASSERT_EQ(ready.size(), 1U);
  EXPECT_FLOAT_EQ(ready[0].reward, 2.0F);
  EXPECT_FLOAT_EQ(ready[0].discount, 0.5F);
  EXPECT_FLOAT_EQ(ready[0].s_next[0], 1.0F);
}

TEST(Returns, FollowNothingAfterTheEndButTheValueAfterACut) {
  const auto agent = any_agent();
  Returns returns{{}, 0.5};
  EXPECT_EQ(returns.add(*agent, step(0.0F, 1.0F, true))[0].discount, 0.0F);
  EXPECT_EQ(returns.add(*agent, step(0.0F, 1.0F, false, true))[0].discount, 0.5F);
}

TEST(Returns, FollowNothingWhereNothingMayBeDone) {
  const auto agent = any_agent();
  Returns returns{{}, 0.5};
  Transition full = step(0.0F, 1.0F, false, true);
  full.next_mask = 0;
  EXPECT_EQ(returns.add(*agent, full)[0].discount, 0.0F);
}

TEST(Returns, RepeatThePublishedFaultsOnDemand) {
  const auto agent = any_agent();
  Returns no_ends{{.legacy_terminals = true}, 0.5};
  EXPECT_EQ(no_ends.add(*agent, step(0.0F, 1.0F, true))[0].discount, 0.5F);
  Returns cuts_end{{.truncation_ends = true}, 0.5};
  EXPECT_EQ(cuts_end.add(*agent, step(0.0F, 1.0F, false, true))[0].discount, 0.0F);
}

TEST(Returns, OfTwoStepsSumTwoRewards) {
  const auto agent = any_agent();
  Returns returns{{.steps = 2, .remaining = true}, 0.5};
  EXPECT_TRUE(returns.add(*agent, step(0.0F, 1.0F)).empty());
  EXPECT_TRUE(returns.add(*agent, step(1.0F, 2.0F)).empty());
  const std::vector<Experience> ready = returns.add(*agent, step(2.0F, 4.0F, true));
  ASSERT_EQ(ready.size(), 3U);
  EXPECT_FLOAT_EQ(ready[0].reward, 1.0F + 0.5F * 2.0F);
  EXPECT_FLOAT_EQ(ready[0].discount, 0.25F);  // gamma^2, then the value of state 2
  EXPECT_FLOAT_EQ(ready[0].s_next[0], 2.0F);
  EXPECT_FLOAT_EQ(ready[1].reward, 2.0F + 0.5F * 4.0F);
  EXPECT_FLOAT_EQ(ready[1].discount, 0.0F);  // the episode has ended within the two steps
  EXPECT_FLOAT_EQ(ready[2].reward, 4.0F);
  // The whole return, the first transition included: 1 + 0.5 (2 + 0.5 * 4).
  EXPECT_FLOAT_EQ(ready[0].remaining, 3.0F);
  EXPECT_FLOAT_EQ(ready[1].remaining, 4.0F);
  EXPECT_FLOAT_EQ(ready[2].remaining, 4.0F);
  EXPECT_TRUE(returns.add(*agent, step(0.0F, 1.0F)).empty());  // nothing is left of the episode before
}

TEST(Returns, RefuseNoStepsAndDiscountsOutsideTheUnitInterval) {
  EXPECT_THROW((Returns{{.steps = 0}, 0.9}), std::invalid_argument);
  EXPECT_THROW((Returns{{}, 1.1}), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
