#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/problem/files.hpp>

namespace modsearch {
namespace {

TEST(RandomDesign, IsUniformOverNumberOfModulesTypesAndParameters) {
  const auto problem = load_problem("seed/fixed");
  Rng rng{1};
  constexpr int kDraws = 9000;
  std::vector<int> lengths(10, 0);
  std::vector<int> first_types(3, 0);
  double sum = 0.0;
  int parameters = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Design design = random_design(*problem, rng);
    ++lengths[design.modules.size()];
    ++first_types[static_cast<std::size_t>(design.modules[0].type)];
    for (const Placement& placement : design.modules) {
      for (const double length : placement.parameters) {
        ASSERT_GE(length, 0.5);
        ASSERT_LE(length, 1.5);
        sum += length;
        ++parameters;
      }
    }
  }
  // Five standard errors of a count with probability p: 5 sqrt(n p (1 - p)).
  EXPECT_EQ(lengths[0], 0);
  for (int n = 1; n <= 9; ++n) EXPECT_NEAR(lengths[static_cast<std::size_t>(n)], kDraws / 9.0, 5 * std::sqrt(kDraws * 8 / 81.0)) << n;
  for (const int count : first_types) EXPECT_NEAR(count, kDraws / 3.0, 5 * std::sqrt(kDraws * 2 / 9.0));
  EXPECT_NEAR(sum / parameters, 1.0, 5 * std::sqrt(1.0 / 12.0 / parameters));
}

TEST(RandomSearch, SpendsItsBudgetOfEvaluationsExactly) {
  const auto problem = load_problem("seed/fixed");
  Meter meter{{.evaluations = 321}};
  const Solution solution = RandomSearch{}.solve(*problem, meter, Rng{0});
  EXPECT_EQ(solution.spent.evaluations, 321);
  EXPECT_EQ(solution.stop, StopReason::kEvaluations);
}

TEST(RandomSearch, GivesEqualAnswersForEqualSeeds) {
  const auto problem = load_problem("seed/random_obstacles");
  const auto solve = [&](std::uint64_t seed) {
    Meter meter{{.evaluations = 500}};
    return RandomSearch{}.solve(*problem, meter, Rng{seed});
  };
  EXPECT_EQ(solve(4).design, solve(4).design);
  EXPECT_EQ(solve(4).evaluation.score, solve(4).evaluation.score);
  EXPECT_NE(solve(4).design, solve(5).design);
}

TEST(RandomSearch, ReportsTheBestOfItsTrace) {
  const auto problem = load_problem("seed/fixed");
  Meter meter{{.evaluations = 2000}};
  const Solution solution = RandomSearch{}.solve(*problem, meter, Rng{2});
  ASSERT_FALSE(meter.trace().empty());
  EXPECT_EQ(meter.trace().back().score, solution.evaluation.score);
  EXPECT_EQ(problem->evaluate(solution.design).score, solution.evaluation.score);
}

}  // namespace
}  // namespace modsearch
