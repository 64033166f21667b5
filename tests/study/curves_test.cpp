#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/study/curves.hpp>

#include "study/synthetic_study.hpp"

namespace modsearch {
namespace {

TEST(RuntimeDistribution, CountsTriplesOfInstanceSeedAndTarget) {
  const StudyRecord record = testing::synthetic_study({.instances = 4, .seeds = 2});
  const StudyRuns runs = runs_of(record, "seed/random_wide");
  const std::vector<Target> targets{{Target::Kind::kAchieved}, {Target::Kind::kFewestModules}};
  const StepFunction steady = runtime_distribution(runs, 0, targets, Measure::kEvaluations);
  EXPECT_EQ(steady.at, std::vector<double>{4.0}) << "both targets are met at once";
  EXPECT_EQ(steady(4.0), 1.0);
  // "slow" fails on one instance of four; of the others one run has not ended: 5 of 7 runs.
  EXPECT_EQ(runtime_distribution(runs, 1, targets, Measure::kEvaluations)(1e9), 5.0 / 7.0);
}

TEST(RuntimeDistribution, ChargesTheTrainingToEveryRunWhereAsked) {
  const StudyRecord record = testing::synthetic_study({.instances = 4, .seeds = 2});
  const StudyRuns runs = runs_of(record);
  const std::vector<Target> targets{{Target::Kind::kAchieved}};
  EXPECT_EQ(runtime_distribution(runs, 2, targets, Measure::kEvaluations).at, std::vector<double>{2.0});
  EXPECT_EQ(runtime_distribution(runs, 2, targets, Measure::kEvaluations, 20'000).at, std::vector<double>{20'002.0});
}

TEST(Convergence, FallsFromTheFirstImprovementToTheEnd) {
  const StudyRecord record = testing::synthetic_study({.instances = 4, .seeds = 3});
  const Convergence curve = convergence(runs_of(record, "seed/random_narrow"), 0, Measure::kEvaluations);
  EXPECT_EQ(curve.spent.front(), 1.0);
  EXPECT_EQ(curve.spent.back(), 4096.0);
  EXPECT_EQ(curve.median.front(), INFINITY) << "nothing is achieved before evaluation 4";
  for (std::size_t i = 1; i < curve.spent.size(); ++i) {
    EXPECT_LT(curve.spent[i - 1], curve.spent[i]);
    EXPECT_GE(curve.median[i - 1], curve.median[i]);
    EXPECT_LE(curve.low[i], curve.median[i]);
    EXPECT_LE(curve.median[i], curve.high[i]);
  }
}

TEST(Convergence, OfNothingIsEmpty) {
  const StudyRecord record = testing::synthetic_study({.instances = 1, .seeds = 1});
  EXPECT_TRUE(convergence(runs_of(record, "another"), 0, Measure::kSeconds).spent.empty());
}

}  // namespace
}  // namespace modsearch
