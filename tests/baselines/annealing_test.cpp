#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/baselines/annealing.hpp>
#include <modsearch/problem/files.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

// PROBLEM 5: the optimum of seed/fixed is one hinge, 350 - 5 (0.5 + sqrt(1.25) - 0.001) = 341.9148; two modules score
// 188 at most.
const double kOptimum = 350.0 - 5.0 * (0.5 + std::sqrt(1.25) - 0.001);

TEST(SimulatedAnnealing, FindsTheThinOneModuleOptimumOfSeedFixed) {
  const auto problem = load_problem("seed/fixed");
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Meter meter{{.evaluations = 5000}};
    const Solution solution = SimulatedAnnealing{}.solve(*problem, meter, Rng{seed});
    EXPECT_EQ(solution.design.modules.size(), 1u) << "seed " << seed;
    EXPECT_GT(solution.evaluation.score, kOptimum - 5.0) << "within a kilogram, seed " << seed;
    EXPECT_LE(solution.evaluation.score, kOptimum + 1e-9);
  }
}

// Six balls of 0.18 m about the target, 0.2 m away along the axes: nothing is proved of a tip that may come from
// anywhere, and the disc of 0.055 m at the end of every module overlaps one of them: seen along (1, 1, 1), the way
// farthest from all of them, its rim at (0.039, -0.039, 0) is 0.166 m away from the centre at (0.2, 0, 0). So no design
// is achieved, whatever its types promise.
TEST(SimulatedAnnealing, GoesOnWhereNothingIsAchieved) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  Obstacle balls;
  balls.name = "balls";
  for (int axis = 0; axis < 3; ++axis) {
    for (const double away : {-0.2, 0.2}) {
      const Eigen::Vector3d p_W = Eigen::Vector3d{1.0, 0.0, 1.0} + away * Eigen::Vector3d::Unit(axis);
      balls.shapes.push_back({Sphere{0.18}, Eigen::Isometry3d{Eigen::Translation3d{p_W}}});
    }
  }
  spec.scene = std::make_shared<Scene>(std::vector<Obstacle>{balls});
  const RobotProblem problem{spec};
  Meter meter{{.evaluations = 2000}};
  const Solution solution = SimulatedAnnealing{}.solve(problem, meter, Rng{1});
  EXPECT_EQ(solution.stop, StopReason::kEvaluations);
  EXPECT_EQ(solution.spent.evaluations, 2000);
  EXPECT_FALSE(solution.evaluation.attempt.achieved);
}

TEST(SimulatedAnnealing, RefusesOptionsOutOfRange) {
  EXPECT_THROW(SimulatedAnnealing{{.cycle = 0}}, std::invalid_argument);
  EXPECT_THROW(SimulatedAnnealing{{.cold = 0.0}}, std::invalid_argument);
  EXPECT_THROW((SimulatedAnnealing{{.hot = 0.1, .cold = 1.0}}), std::invalid_argument);
  EXPECT_THROW(SimulatedAnnealing{{.structure = 1.5}}, std::invalid_argument);
  EXPECT_THROW(SimulatedAnnealing{{.penalty = -1.0}}, std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
