#include <gtest/gtest.h>

#include <limits>
#include <modsearch/problem/scoring.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

double algorithm1(int modules, double mass, bool reached, bool collides, double relative_error = 0.0) {
  return Algorithm1{}
      .terms({.modules = modules, .mass = mass, .reached = reached, .achieved = reached && !collides,
              .collides = collides, .relative_error = relative_error})
      .sum();
}

// Table I of the report: its one-module agents as total lengths of 1.90, 1.96 and 2.02 m, PA-DDPG as two modules with all
// four lengths at the upper bound of 1.5 m.
TEST(Algorithm1, GivesTheRewardsOfTheReportsTableOne) {
  EXPECT_NEAR(algorithm1(2, 1.90, true, false), 340.5, 1e-9);
  EXPECT_NEAR(algorithm1(2, 1.96, true, false), 340.2, 1e-9);
  EXPECT_NEAR(algorithm1(2, 2.02, true, false), 339.9, 1e-9);
  EXPECT_NEAR(algorithm1(3, 4 * 1.5, true, false), 50.0 + 150.0 - 2.0 - 5.0 * 6.0, 1e-9);
  EXPECT_NEAR(algorithm1(3, 4 * 1.5, true, false), 168.0, 1e-9);
}

// Modules of the seed library weigh between 0.5 kg (a link of 0.5 m) and 3 kg (two cylinders of 1.5 m).
TEST(Algorithm1, GivesTheScoreRangesOfReachingDesigns) {
  const auto worst = [](int n) { return algorithm1(n, 3.0 * (n - 1), true, false); };
  const auto best = [](int n) { return algorithm1(n, 0.5 * (n - 1), true, false); };
  EXPECT_NEAR(worst(2), 335.0, 1e-9);
  EXPECT_NEAR(best(2), 347.5, 1e-9);
  EXPECT_NEAR(worst(3), 168.0, 1e-9);
  EXPECT_NEAR(best(3), 193.0, 1e-9);
  EXPECT_NEAR(worst(4), 76.0, 1e-9);
  EXPECT_NEAR(best(4), 113.5, 1e-9);
  EXPECT_NEAR(worst(5), 21.5, 1e-9);
  EXPECT_NEAR(best(5), 71.5, 1e-9);
}

TEST(Algorithm1, GivesTheEmptyDesignPlusOne) { EXPECT_NEAR(algorithm1(1, 0.0, false, false, 1.0), 1.0, 1e-12); }

TEST(Algorithm1, TakesThirtyPointsForACollision) {
  EXPECT_NEAR(algorithm1(2, 1.0, true, true), algorithm1(2, 1.0, true, false) - 30.0, 1e-12);
}

TEST(Algorithm1, NamesItsTerms) {
  const Terms terms = Algorithm1{}.terms({.modules = 3, .mass = 2.0, .reached = true, .collides = true});
  ASSERT_EQ(terms.items().size(), 4u);
  EXPECT_EQ(name(terms.items()[0].id), "reached");
  EXPECT_EQ(terms.items()[0].value, 200.0);
  EXPECT_EQ(name(terms.items()[1].id), "module");
  EXPECT_EQ(terms.items()[1].value, -2.0);
  EXPECT_EQ(name(terms.items()[2].id), "mass");
  EXPECT_EQ(terms.items()[2].value, -10.0);
  EXPECT_EQ(name(terms.items()[3].id), "collision");
  EXPECT_EQ(terms.sum(), 200.0 - 2.0 - 10.0 - 30.0);
}

TEST(Algorithm1, BoundIsTheScoreOfAReachingDesignOfThatMass) {
  EXPECT_EQ(Algorithm1{}.bound(2, 1.25, 0.0), algorithm1(2, 1.25, true, false));
}

TEST(WeightedScoring, FollowsItsFormula) {
  const WeightedScoring scoring{
      {.reached = 100, .distance = 10, .module = 2, .mass = 3, .cost = 0.5, .collision = 40}};
  const Facts achieved{.modules = 4, .mass = 2.5, .cost = 6.0, .reached = true, .achieved = true};
  EXPECT_NEAR(scoring.terms(achieved).sum(), 100.0 - 2.0 * 3 - 3.0 * 2.5 - 0.5 * 6.0, 1e-12);
  const Facts missed{.modules = 2, .mass = 1.0, .collides = true, .relative_error = 0.25};
  EXPECT_NEAR(scoring.terms(missed).sum(), -10.0 * 0.25 - 2.0 - 3.0 - 40.0, 1e-12);
}

TEST(WeightedScoring, RefusesWeightsThatAreNegativeOrNotFinite) {
  EXPECT_THROW(WeightedScoring({.mass = -1.0}), std::invalid_argument);
  EXPECT_THROW(WeightedScoring({.reached = std::numeric_limits<double>::quiet_NaN()}), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
