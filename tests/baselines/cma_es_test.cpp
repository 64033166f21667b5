#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/baselines/cma_es.hpp>
#include <modsearch/problem/files.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

// PROBLEM 5: the optimum of seed/fixed is one hinge, 350 - 5 (0.5 + sqrt(1.25) - 0.001) = 341.9148, at the lower bound
// of one length and within a millimetre of the other.
const double kOptimum = 350.0 - 5.0 * (0.5 + std::sqrt(1.25) - 0.001);

TEST(CmaEs, FindsTheOptimumOfSeedFixedWithoutDerivatives) {
  const auto problem = load_problem("seed/fixed");
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Meter meter{{.evaluations = 5000}};
    const Solution solution = CmaEs{}.solve(*problem, meter, Rng{seed});
    EXPECT_EQ(solution.design.modules.size(), 1u) << "seed " << seed;
    EXPECT_GT(solution.evaluation.score, kOptimum - 0.5) << "seed " << seed;
    EXPECT_LE(solution.evaluation.score, kOptimum + 1e-9);
  }
}

// At (0, 3, 3) the target is 4.24 m away: one module of at most 3 m is not enough, and the bounds say so beforehand.
TEST(CmaEs, BeginsWithAsManyModulesAsTheDistanceAsksFor) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.task = std::make_shared<GoalTask>(
      "two", std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::ball({0.0, 3.0, 3.0}, 1e-3)}});
  const RobotProblem problem{spec};
  Meter meter{{.evaluations = 3000}};
  const Solution solution = CmaEs{}.solve(problem, meter, Rng{1});
  EXPECT_TRUE(solution.evaluation.attempt.achieved);
  EXPECT_EQ(solution.design.modules.size(), 2u);
}

TEST(CmaEs, SearchesPaddedDesignsToo) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.max_modules = 4;
  const RobotProblem problem{spec};
  Meter meter{{.evaluations = 2000}};
  const Solution solution = CmaEs{{.space = CmaEsOptions::Space::kPadded}}.solve(problem, meter, Rng{1});
  EXPECT_TRUE(solution.evaluation.attempt.achieved);
}

TEST(CmaEs, NamesItsSpaces) {
  EXPECT_EQ(space_from_name("padded"), CmaEsOptions::Space::kPadded);
  EXPECT_EQ(name(CmaEsOptions::Space::kLengths), "lengths");
  EXPECT_FALSE(space_from_name("elsewhere").has_value());
}

TEST(CmaEs, RefusesOptionsOutOfRange) {
  EXPECT_THROW(CmaEs{{.population = 3}}, std::invalid_argument);
  EXPECT_THROW(CmaEs{{.growth = 0.5}}, std::invalid_argument);
  EXPECT_THROW(CmaEs{{.sigma = 0.0}}, std::invalid_argument);
  EXPECT_THROW(CmaEs{{.least_sigma = 0.0}}, std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
