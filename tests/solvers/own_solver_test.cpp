// What the project's own solver promises beyond the contract of inner_solver_test.cpp.
#include <gtest/gtest.h>

#include <modsearch/solvers/inner_solver.hpp>

#include "solvers/test_programs.hpp"

namespace modsearch::test {
namespace {

InnerResult solve(SmoothProgram& program, const Eigen::VectorXd& start, InnerOptions options = {}) {
  Meter meter;
  return minimise(Inner::kOwn, program, start, options, meter);
}

// How many of `arms` random arms with reachable targets are solved from their first start.
int solved_from_first_start(int joints, int arms) {
  int solved = 0;
  for (int i = 0; i < arms; ++i) {
    ArmProgram arm = random_arm(joints, 5000U + static_cast<unsigned>(i));
    if (solve(arm, arm.start(0)).status == InnerStatus::kConverged) ++solved;
  }
  return solved;
}

// One start is a local search: with few joints, half the starts lead to a posture from which the target only gets
// farther. The figures are what is found, less a margin for other roundings; more joints leave fewer dead ends.
TEST(OwnSolver, SolvesMostArmsFromOneStart) {
  EXPECT_GE(solved_from_first_start(2, 100), 50);
  EXPECT_GE(solved_from_first_start(3, 100), 65);
  EXPECT_GE(solved_from_first_start(4, 100), 88);
  EXPECT_GE(solved_from_first_start(5, 100), 92);
}

TEST(OwnSolver, NeedsFewEvaluations) {
  std::int64_t evaluations = 0;
  for (unsigned i = 0; i < 100; ++i) {
    ArmProgram arm = random_arm(5, 5000 + i);
    evaluations += solve(arm, arm.start(0)).evaluations;
  }
  EXPECT_LE(evaluations, 100 * 25);
}

// Stretched upright, q = 0: the target lies sideways, and every derivative of the distance in the yaw angle is zero.
TEST(OwnSolver, LeavesASingularStart) {
  ArmProgram arm{{.axes = "zyy", .target = {0.9, 0.0, 1.2}}};
  const InnerResult result = solve(arm, Eigen::VectorXd::Zero(6));
  EXPECT_EQ(result.status, InnerStatus::kConverged);
  EXPECT_LE(result.violation, 1e-9);
}

// The first length stands upright, the other two, 3 m at most, have to be stretched straight to come within 1 mm of a
// point 3 m away: singular at the only solutions. The lower p, the shorter the arm, as |(3, p - 1)| <= 3 + 0.001
// allows.
TEST(OwnSolver, SolvesAtTheLimitOfReach) {
  ArmProgram arm{{.axes = "zyy", .target = {3.0, 0.0, 1.0}}};
  Eigen::VectorXd start(6);
  start << 1.0, 1.0, 1.0, 0.1, 1.2, 0.4;
  const InnerResult result = solve(arm, start);
  EXPECT_EQ(result.status, InnerStatus::kConverged);
  EXPECT_LE(result.violation, 1e-9);
  EXPECT_NEAR(result.objective, 3.0 + 1.0 - std::sqrt(3.001 * 3.001 - 9.0), 1e-7);
}

TEST(OwnSolver, ReachesTheAccuracyItIsAskedFor) {
  for (const double tolerance : {1e-4, 1e-7, 1e-11}) {
    ArmProgram arm = OneHinge::program();
    Eigen::VectorXd start(4);
    start << 1.0, 1.0, 0.3, 1.0;
    const InnerResult result = solve(arm, start, {.tolerance = tolerance});
    EXPECT_EQ(result.status, InnerStatus::kConverged);
    EXPECT_LE(result.violation, tolerance);
    EXPECT_NEAR(result.objective, OneHinge::optimum(), 3.0 * tolerance);
  }
}

TEST(OwnSolver, SolvesAnEqualityOfRadiusZero) {
  ArmProgram arm{{.axes = "zy", .radius = 0.0}};
  Eigen::VectorXd start(4);
  start << 1.0, 1.0, 0.3, 1.0;
  const InnerResult result = solve(arm, start);
  EXPECT_EQ(result.status, InnerStatus::kConverged);
  EXPECT_NEAR(result.objective, 0.5 + std::sqrt(1.25), 1e-8);
}

// A limit that is too small is told, with the best point of the way.
TEST(OwnSolver, ReportsTheLimitOfIterations) {
  ArmProgram arm = OneHinge::program();
  const InnerResult result = solve(arm, arm.start(0), {.max_iterations = 2});
  EXPECT_EQ(result.status, InnerStatus::kLimit);
  EXPECT_LE(result.evaluations, 3);
}

}  // namespace
}  // namespace modsearch::test
