#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <modsearch/baselines/enumerate.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/robot_problem.hpp>

#include "baselines/tiny_problems.hpp"
#include "contracts/problem_contract.hpp"
#include "problem/temporary_folder.hpp"
#include "places.hpp"

namespace modsearch {
namespace {

using testing::blocks;
using ::testing::HasSubstr;
using testing::Stacks;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Solution solved(const DesignProblem& problem, Budget budget = {}) {
  Meter meter{budget};
  return Enumerate{}.solve(problem, meter, Rng{1});
}

/// The best score of an achieved design without parameters, by trying all.
double best_of_all(const DesignProblem& problem) {
  double best = -kInfinity;
  std::vector<Design> open{Design{}};
  while (!open.empty()) {
    const Design design = std::move(open.back());
    open.pop_back();
    const Evaluation evaluation = problem.evaluate(design);
    if (evaluation.attempt.achieved) best = std::max(best, evaluation.score);
    for (const int k : problem.successors(design.types())) {
      open.push_back(design);
      open.back().modules.push_back({k, Parameters{}});
    }
  }
  return best;
}

TEST(Enumerate, FindsTheBestOfADiscreteSpaceAndProvesIt) {
  Rng rng{3};
  for (int i = 0; i < 50; ++i) {
    Stacks::Spec spec{
        .library = blocks({false, false, false}), .toll = rng.uniform(0.0, 2.0), .goal = 1 + rng.index(8)};
    for (int k = 0; k < 3; ++k) spec.values.push_back(rng.uniform(-1.0, 1.0));
    const Stacks problem{spec};
    const Solution solution = solved(problem);
    EXPECT_EQ(solution.stop, StopReason::kOptimal);
    EXPECT_EQ(solution.evaluation.score, best_of_all(problem));
    ASSERT_TRUE(solution.bound.has_value());
    EXPECT_EQ(solution.bound->score, solution.evaluation.score);
    // 1 + 3 + 9 + 27 + 81 designs of up to four modules.
    EXPECT_LE(solution.spent.evaluations, 121);
  }
}

// Values 5, 1, 0 and a toll of 0.1: the best stack of up to four is four of the first, 20 - 0.4, and it is the first in
// the order of the bounds. The empty design comes before it.
TEST(Enumerate, CutsOffWhatCannotWin) {
  const Stacks problem{{.library = blocks({false, false, false}), .values = {5.0, 1.0, 0.0}, .toll = 0.1, .goal = 4}};
  const Solution solution = solved(problem);
  EXPECT_EQ(solution.stop, StopReason::kOptimal);
  EXPECT_EQ(solution.design.types(), (std::vector<int>{0, 0, 0, 0}));
  EXPECT_EQ(solution.spent.evaluations, 2);
}

TEST(Enumerate, EvaluatesEveryDesignWhereNothingIsKnownBeforehand) {
  const Stacks problem{
      {.library = blocks({false, false, false}), .values = {5.0, 1.0, 0.0}, .goal = 3, .bounds = false}};
  const Solution solution = solved(problem);
  EXPECT_EQ(solution.spent.evaluations, 121);
  EXPECT_EQ(solution.evaluation.score, best_of_all(problem));
  EXPECT_EQ(solution.stop, StopReason::kOptimal);
}

// Four modules of index + 1 up to 3 add up to at most 12.
TEST(Enumerate, ProvesOfADiscreteSpaceThatNothingIsAchieved) {
  const Stacks problem{{.library = blocks({false, false, false}), .values = {5.0, 1.0, 0.0}, .goal = 13}};
  const Solution solution = solved(problem);
  EXPECT_EQ(solution.stop, StopReason::kUnreachable);
  EXPECT_THAT(solution.reason,
              HasSubstr("120 designs could reach by their bounds; all were evaluated, none is achieved"));
}

TEST(Enumerate, SaysOfParametersHowMuchIsLeftOpen) {
  const Stacks problem{
      {.library = blocks({true, false}), .values = {2.0, 1.0}, .toll = 0.5, .goal = 2, .max_modules = 3}};
  const Solution solution = solved(problem);
  // Two of the first, each 2 + height - 0.5: at most 5, which samples come close to and do not prove.
  EXPECT_EQ(solution.design.types(), (std::vector<int>{0, 0}));
  EXPECT_GT(solution.evaluation.score, 4.0);
  EXPECT_EQ(solution.stop, StopReason::kExhausted);
  ASSERT_TRUE(solution.bound.has_value());
  EXPECT_EQ(solution.bound->score, 5.0);
}

TEST(Enumerate, GivesABoundThatHoldsWheneverItIsStopped) {
  const Stacks problem{{.library = blocks({false, false, false}), .values = {1.0, 3.0, 2.0}, .toll = 1.5, .goal = 5}};
  const double best = best_of_all(problem);
  for (std::int64_t budget = 1; budget < 60; ++budget) {
    const Solution solution = solved(problem, {.evaluations = budget});
    ASSERT_TRUE(solution.bound.has_value()) << budget;
    EXPECT_GE(solution.bound->score, best) << budget;
  }
}

TEST(Enumerate, FindsTheOptimumOfTheReferenceProblemWithinItsBound) {
  const Solution solution = solved(*load_problem("seed/fixed"));
  EXPECT_NEAR(solution.evaluation.score, 341.9148, 1e-4);  // PROBLEM 5
  ASSERT_TRUE(solution.bound.has_value());
  // The bound knows only that an arm has to be as long as the target is far: sqrt(2) m less the tolerance.
  EXPECT_NEAR(solution.bound->score, 350.0 - 5.0 * (std::sqrt(2.0) - 0.001), 1e-4);
}

TEST(Enumerate, ResumesWhereItWasCutOff) {
  const test::TemporaryFolder folder;
  const Stacks discrete{
      {.library = blocks({false, false, false}), .values = {1.0, 3.0, 2.0}, .toll = 1.5, .goal = 5, .bounds = false}};
  testing::expect_resumable_contract(Enumerate{}, discrete, folder.path(), 60);
  const Stacks continuous{
      {.library = blocks({true, false}), .values = {2.0, 1.0}, .toll = 0.5, .goal = 2, .max_modules = 3}};
  testing::expect_resumable_contract(Enumerate{}, continuous, folder.path(), 250);
}

}  // namespace
}  // namespace modsearch
