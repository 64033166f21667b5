#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/rl/random_policy.hpp>
#include <stdexcept>
#include <string>

namespace modsearch {
namespace {

using ::testing::HasSubstr;

/// Share of 200 instances that one module of the policy achieves.
double one_module_share(const std::string& problem, RandomPolicyOptions options) {
  const ProblemFile family = load_problem_file(problem);
  const RandomPolicy policy{std::move(options)};
  int one = 0;
  constexpr int kInstances = 200;
  for (std::uint64_t i = 0; i < kInstances; ++i) {
    const auto instance = family.instance({.seed = 1, .index = i});
    Meter meter;
    const Solution solution = policy.solve(*instance, meter, Rng{i});
    one += solution.evaluation.attempt.achieved && solution.design.modules.size() == 1;
  }
  return static_cast<double>(one) / kInstances;
}

// A prototype with its own kinematics counted 0.974 and 0.999 of 1000 narrow targets for one and four random hinges
// with at most three Gauss-Newton steps, 0.786 and 0.969 among the obstacles (with capsules for cylinders). Of 200
// targets such shares differ by 0.03 (0.974) to 0.09 (0.786), three standard deviations.
TEST(RandomPolicy, AchievesWhatAnIndependentPrototypeOfItDid) {
  EXPECT_NEAR(one_module_share("seed/random_narrow", {.type = "hinge"}), 0.974, 0.034);
  EXPECT_NEAR(one_module_share("seed/random_narrow", {.proposals = 4, .type = "hinge"}), 0.999, 0.01);
  EXPECT_NEAR(one_module_share("seed/random_obstacles", {.type = "hinge"}), 0.786, 0.09);
  EXPECT_NEAR(one_module_share("seed/random_obstacles", {.proposals = 4, .type = "hinge"}), 0.969, 0.037);
}

TEST(RandomPolicy, NeedsThePolish) {
  // One random placement in about 1500 reaches by itself.
  EXPECT_LE(one_module_share("seed/random_narrow", {.polish = 0}), 0.015);
}

TEST(RandomPolicy, IsChargedForEveryProposalAndForThePlacement) {
  const auto problem = load_problem("seed/fixed");
  Meter meter;
  const Solution solution = RandomPolicy{{.proposals = 4, .type = "hinge"}}.solve(*problem, meter, Rng{0});
  ASSERT_EQ(solution.design.modules.size(), 1U);
  EXPECT_EQ(solution.spent.evaluations, 4 + 1);
  EXPECT_GT(solution.spent.work.ik_iterations + solution.spent.work.forward, 0);
}

TEST(RandomPolicy, GoesOnFromADesignThatReachesButCollides) {
  const ProblemFile family = load_problem_file("seed/random_obstacles");
  int longer = 0;
  for (std::uint64_t i = 0; i < 50; ++i) {
    const auto problem = family.instance({.seed = 1, .index = i});
    Meter meter;
    const Solution solution = RandomPolicy{{.type = "hinge"}}.solve(*problem, meter, Rng{i});
    longer += solution.design.modules.size() > 1 && solution.evaluation.attempt.achieved;
  }
  EXPECT_GT(longer, 0);
}

TEST(RandomPolicy, KeepsToItsBudget) {
  const auto problem = load_problem("seed/fixed");
  Meter meter{{.evaluations = 3}};
  EXPECT_EQ((RandomPolicy{{.proposals = 8}}.solve(*problem, meter, Rng{0}).spent.evaluations), 3);
}

TEST(RandomPolicy, RefusesWhatIsNotThere) {
  EXPECT_THROW(RandomPolicy{{.proposals = 0}}, std::invalid_argument);
  EXPECT_THROW(RandomPolicy{{.polish = -1}}, std::invalid_argument);
  const auto problem = load_problem("seed/fixed");
  Meter meter;
  try {
    static_cast<void>(RandomPolicy{{.type = "elbow"}}.solve(*problem, meter, Rng{0}));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("type 'elbow': library 'seed' has none"));
  }
}

}  // namespace
}  // namespace modsearch
