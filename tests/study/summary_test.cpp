#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/study/summary.hpp>

#include "study/synthetic_study.hpp"

namespace modsearch {
namespace {

class SummaryTest : public ::testing::Test {
 protected:
  StudyRecord record_ = testing::synthetic_study({.instances = 8, .seeds = 5});
  Summary summary_ = summarise(record_, runs_of(record_, "seed/random_narrow"), Rng{0}, {.resamples = 200});
};

TEST_F(SummaryTest, CountsRunsAndSuccesses) {
  ASSERT_EQ(summary_.rows.size(), 3u);
  EXPECT_EQ(summary_.rows[0].label, "steady");
  EXPECT_EQ(summary_.rows[0].runs, 40);
  EXPECT_EQ(summary_.rows[0].achieved.value, 1.0);
  // "slow" fails on the last instance with all five seeds, and one run crashed.
  EXPECT_EQ(summary_.rows[1].failed, 1);
  EXPECT_EQ(summary_.rows[1].achieved.value, 34.0 / 40.0);
}

TEST_F(SummaryTest, ChargesFailuresToTheExpectedRuntime) {
  // 34 runs achieve the task at evaluation 4; five fail after 4096 and one crashed with that budget.
  EXPECT_EQ(summary_.rows[1].evaluations[0], (34.0 * 4.0 + 6.0 * 4096.0) / 34.0);
  EXPECT_EQ(summary_.rows[0].evaluations[0], 4.0);
}

TEST_F(SummaryTest, FindsTheBetterSolver) {
  const Comparison& comparison = summary_.comparisons[0];
  EXPECT_EQ(comparison.first, 0u);
  EXPECT_EQ(comparison.second, 1u);
  EXPECT_GT(comparison.improvement.value, 0.95);
  EXPECT_EQ(comparison.test.pairs, 8);
  // All eight instances agree: 2 / 2^8, times three comparisons.
  EXPECT_EQ(comparison.test.p, 2.0 / 256.0);
  EXPECT_EQ(comparison.p, 6.0 / 256.0);
  EXPECT_TRUE(summary_.paired_by_instance);
}

TEST_F(SummaryTest, PairsSeedsWhereThereIsOneInstance) {
  const StudyRecord record = testing::synthetic_study({.instances = 1, .seeds = 7, .bounds = true});
  const Summary summary = summarise(record, runs_of(record, "seed/random_wide"), Rng{0}, {.resamples = 50});
  EXPECT_FALSE(summary.paired_by_instance);
  EXPECT_EQ(summary.comparisons[1].test.pairs, 7);
}

TEST_F(SummaryTest, SaysWhatIsCertified) {
  EXPECT_EQ(summary_.instances, 8);
  EXPECT_EQ(summary_.bounded + summary_.optimal, 8);
  EXPECT_GT(summary_.largest_gap, 0.0);
  const Summary open = summarise(record_, runs_of(record_, "seed/random_wide"), Rng{0}, {.resamples = 50});
  EXPECT_EQ(open.bounded + open.optimal, 0);
}

TEST_F(SummaryTest, FindsWhereLearningPays) {
  // Within 10 % of the least mass: the agent needs its two evaluations, "slow" more than 80.
  std::size_t target = 0;
  while (summary_.targets[target].percent != 10.0) ++target;
  const std::vector<BreakEven> points = break_evens(summary_, target, Measure::kEvaluations);
  ASSERT_EQ(points.size(), 2u);
  const double use = summary_.rows[2].evaluations[target];
  EXPECT_EQ(points[1].classical, 1u);
  EXPECT_EQ(points[1].tasks, 20'000.0 / (summary_.rows[1].evaluations[target] - use));
}

TEST_F(SummaryTest, ComparesCostsAtTheHardestTargetThatBothKindsMeetInHalfOfTheirRuns) {
  // The agent has about 3 % too much: within 5 % it is in most of its runs, within 2 % in few.
  EXPECT_EQ(summary_.targets[telling_target(summary_)].name(), "mass within 5 %");
  for (SummaryRow& row : summary_.rows) row.trained = false;
  EXPECT_EQ(summary_.targets[telling_target(summary_)].name(), "mass within 0.1 %");
}

TEST_F(SummaryTest, IsAFunctionOfItsGenerator) {
  const StudyRuns runs = runs_of(record_);
  const Summary a = summarise(record_, runs, Rng{5}, {.resamples = 50});
  const Summary b = summarise(record_, runs, Rng{5}, {.resamples = 50});
  EXPECT_EQ(a.rows[0].regret.low, b.rows[0].regret.low);
  EXPECT_EQ(a.comparisons[0].improvement.high, b.comparisons[0].improvement.high);
}

}  // namespace
}  // namespace modsearch
