#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/study/bootstrap.hpp>
#include <stdexcept>

#include "study/reference.hpp"

namespace modsearch {
namespace {

TEST(InterquartileMean, IsTheTrimmedMeanOfSciPy) {
  for (const auto& expected : testing::reference("trimmed")) {
    EXPECT_NEAR(interquartile_mean(expected["values"].get<std::vector<double>>()), expected["mean"], 1e-12);
  }
}

TEST(InterquartileMean, OverAllRunsOfAllTasksIsThatOfRliable) {
  const Strata first = testing::reference("first");
  EXPECT_NEAR(interquartile_mean(first, Rng{1}).value, testing::reference("interquartile_mean"), 1e-12);
}

TEST(InterquartileMean, HasTheEndsOfTheWholeBootstrapDistribution) {
  // All 27 x 27 ways to draw were counted. The distribution is discrete, so that enough resamples hit its quantiles.
  const auto expected = testing::reference("bootstrap");
  const Estimate estimate = interquartile_mean(expected["strata"].get<Strata>(), Rng{1}, {.resamples = 50'000});
  EXPECT_NEAR(estimate.low, expected["interval"][0], 1e-12);
  EXPECT_NEAR(estimate.high, expected["interval"][1], 1e-12);
}

TEST(InterquartileMean, ResamplesWithinTasksOnly) {
  // Runs that agree within each task leave nothing to chance, however far the tasks are apart.
  const Estimate estimate = interquartile_mean(Strata{{1, 1, 1, 1}, {5, 5, 5, 5}}, Rng{1});
  EXPECT_EQ(estimate.value, 3.0);
  EXPECT_EQ(estimate.low, 3.0);
  EXPECT_EQ(estimate.high, 3.0);
}

TEST(InterquartileMean, StaysFiniteWhereAtMostAQuarterFails) {
  EXPECT_EQ(interquartile_mean({1, 2, 3, INFINITY}), 2.5);
  EXPECT_EQ(interquartile_mean({1, 2, INFINITY, INFINITY}), INFINITY);
  EXPECT_EQ(interquartile_mean(Strata{{INFINITY, INFINITY}}, Rng{1}).low, INFINITY);
}

TEST(ProbabilityOfImprovement, IsThatOfRliable) {
  const Strata first = testing::reference("first"), second = testing::reference("second");
  const double expected = testing::reference("probability_of_improvement");
  EXPECT_NEAR(probability_of_improvement(first, second, Rng{1}).value, expected, 1e-12);
  EXPECT_NEAR(probability_of_improvement(second, first, Rng{1}).value, 1.0 - expected, 1e-12);
}

TEST(ProbabilityOfImprovement, IsAHalfAgainstOneselfAndOneAgainstTheWorse) {
  const Strata results{{1, 2, 3}, {4, 5, INFINITY}}, worse{{0, 0, 0}, {-1, -2, -INFINITY}};
  EXPECT_EQ(probability_of_improvement(results, results, Rng{1}).value, 0.5);
  const Estimate clear = probability_of_improvement(results, worse, Rng{1});
  EXPECT_EQ(clear.low, 1.0);
  EXPECT_EQ(clear.high, 1.0);
}

TEST(Bootstrap, IsAFunctionOfItsGenerator) {
  const Strata first = testing::reference("first");
  EXPECT_EQ(interquartile_mean(first, Rng{3}).low, interquartile_mean(first, Rng{3}).low);
}

TEST(Bootstrap, RefusesTasksWithoutRunsAndNaN) {
  EXPECT_THROW((void)interquartile_mean(Strata{}, Rng{1}), std::invalid_argument);
  EXPECT_THROW((void)interquartile_mean(Strata{{1.0}, {}}, Rng{1}), std::invalid_argument);
  EXPECT_THROW((void)interquartile_mean(Strata{{NAN}}, Rng{1}), std::invalid_argument);
  EXPECT_THROW((void)interquartile_mean(Strata{{1.0}}, Rng{1}, {.resamples = 0}), std::invalid_argument);
  EXPECT_THROW((void)probability_of_improvement({{1.0}}, {{1.0}, {2.0}}, Rng{1}), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
