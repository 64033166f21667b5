#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/study/break_even.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

TEST(BreakEven, IsWhereBothCostTheSamePerTask) {
  const AmortisedCost trained{.training = 90'000, .use = 100};
  EXPECT_EQ(break_even_tasks(trained, 1000), 100.0);
  EXPECT_EQ(trained.per_task(100), 1000.0);
  EXPECT_EQ(trained.per_task(1), 90'100.0);
}

TEST(BreakEven, IsNeverWhereUseIsNotCheaper) {
  EXPECT_EQ(break_even_tasks({.training = 1, .use = 5}, 5), INFINITY);
  EXPECT_EQ(break_even_tasks({.training = 1, .use = 6}, 5), INFINITY);
  EXPECT_EQ(break_even_tasks({.training = 1, .use = INFINITY}, INFINITY), INFINITY);
}

TEST(BreakEven, IsAtOnceWhereOnlyTheTrainedSolverMeetsTheQuality) {
  EXPECT_EQ(break_even_tasks({.training = 1e6, .use = 5}, INFINITY), 0.0);
}

TEST(BreakEven, RefusesNegativeCosts) {
  EXPECT_THROW((void)break_even_tasks({.training = -1, .use = 0}, 1), std::invalid_argument);
  EXPECT_THROW((void)break_even_tasks({.training = 1, .use = NAN}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
