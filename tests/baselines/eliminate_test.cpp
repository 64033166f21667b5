#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <modsearch/baselines/eliminate.hpp>
#include <modsearch/baselines/enumerate.hpp>
#include <modsearch/problem/files.hpp>
#include <numeric>

#include "baselines/tiny_problems.hpp"
#include "contracts/problem_contract.hpp"
#include "problem/temporary_folder.hpp"
#include "places.hpp"

namespace modsearch {
namespace {

using testing::blocks;
using ::testing::HasSubstr;
using testing::Stacks;

Solution solved(const DesignProblem& problem, EliminateOptions options = {}, Budget budget = {}) {
  Meter meter{budget};
  return Eliminate{options}.solve(problem, meter, Rng{1});
}

double count(const Solution& solution, const std::string& what) {
  for (const Tally& tally : solution.tallies) {
    if (tally.what == what) return tally.count;
  }
  return 0.0;
}

/// Every design is counted once: all of them = the sum of what the stages removed and what passed.
void expect_counts_add_up(const Solution& solution) {
  ASSERT_FALSE(solution.tallies.empty());
  EXPECT_EQ(solution.tallies.front().what, "designs");
  double sum = 0.0;
  for (std::size_t i = 1; i < solution.tallies.size(); ++i) sum += solution.tallies[i].count;
  EXPECT_EQ(sum, solution.tallies.front().count);
}

// 3 + 9 + 27 + 81 stacks of up to four blocks that count 1, 2 and 3. Four is the sum of 3+1, 1+3, 2+2, the three
// orders of 1+1+2, and 1+1+1+1: seven stacks, all others miss. Nothing is known beforehand, so all are tested; only as
// many score more than the one before as there are better ones to come.
TEST(Eliminate, CountsWhatEachStageRemoves) {
  const Stacks problem{
      {.library = blocks({false, false, false}), .values = {1.0, 1.0, 1.0}, .goal = 4, .bounds = false}};
  const Solution solution = solved(problem);
  expect_counts_add_up(solution);
  EXPECT_EQ(count(solution, "designs"), 120.0);
  EXPECT_EQ(count(solution, "unreachable"), 113.0);
  // Two modules, then three, then four: each once better than before.
  EXPECT_EQ(count(solution, "achieved"), 3.0);
  EXPECT_EQ(count(solution, "score bound"), 4.0);
  EXPECT_EQ(solution.stop, StopReason::kOptimal);
  EXPECT_EQ(solution.evaluation.score, 4.0);
}

TEST(Eliminate, AgreesWithEnumeration) {
  Rng rng{5};
  for (int i = 0; i < 40; ++i) {
    Stacks::Spec spec{
        .library = blocks({false, false, false}), .toll = rng.uniform(0.0, 2.0), .goal = 1 + rng.index(13)};
    for (int k = 0; k < 3; ++k) spec.values.push_back(rng.uniform(-1.0, 1.0));
    const Stacks problem{spec};
    const Solution solution = solved(problem);
    Meter meter;
    const Solution reference = Enumerate{}.solve(problem, meter, Rng{1});
    EXPECT_EQ(solution.stop, reference.stop);
    EXPECT_EQ(solution.evaluation.score, reference.evaluation.score);
    expect_counts_add_up(solution);
  }
}

// seed/random_obstacles with one value of 1 m per length and up to two modules: 3 + 9 designs.
TEST(Eliminate, PutsParametersOnAGridAndSaysSo) {
  RobotProblemSpec spec = load_problem("seed/random_obstacles", {5, 2})->spec();
  spec.max_modules = 3;
  const Solution solution = solved(RobotProblem{spec}, {.grid = 1});
  EXPECT_EQ(count(solution, "designs"), 12.0);
  expect_counts_add_up(solution);
  EXPECT_EQ(solution.stop, StopReason::kExhausted);
  EXPECT_THAT(solution.reason, HasSubstr("the best of the grid"));
  for (const Placement& placement : solution.design.modules) {
    EXPECT_TRUE((placement.parameters.array() == 1.0).all());
  }
}

// The best of a grid that holds every combination of the ends, by trying them all.
TEST(Eliminate, FindsTheBestOfItsGrid) {
  RobotProblemSpec spec = load_problem("seed/random_obstacles", {5, 2})->spec();
  spec.max_modules = 3;
  const RobotProblem problem{spec};
  double best = -std::numeric_limits<double>::infinity();
  std::vector<Design> open{Design{}};
  while (!open.empty()) {
    const Design design = std::move(open.back());
    open.pop_back();
    const Evaluation evaluation = problem.evaluate(design);
    if (evaluation.attempt.achieved) best = std::max(best, evaluation.score);
    for (const int k : problem.successors(design.types())) {
      const int n = problem.library().type(k).n_parameters();
      for (int corner = 0; corner < 1 << n; ++corner) {
        Placement placement{k, Parameters(n)};
        for (int i = 0; i < n; ++i) placement.parameters[i] = corner >> i & 1 ? 1.5 : 0.5;
        open.push_back(design);
        open.back().modules.push_back(placement);
      }
    }
  }
  ASSERT_TRUE(std::isfinite(best));
  const Solution solution = solved(problem, {.grid = 2});
  EXPECT_NEAR(solution.evaluation.score, best, 1e-9);
  expect_counts_add_up(solution);
}

// Timor's primitive modules: nine types, the end effector last. Connectors exclude only what would follow it.
TEST(Eliminate, TellsWhatItRemovesOfARecordedLibrary) {
  const std::filesystem::path file = test::shared_folder() / "data/timor/geometric_primitive_modules/modules.json";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no recorded files under " << test::shared_folder();
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.library = load_library(file.string());
  spec.max_modules = 5;
  spec.level = Level::kPostureSelf;
  spec.task = std::make_shared<GoalTask>(
      "near", std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::ball({0.2, 0.1, 0.3}, 0.05)}});
  const RobotProblem problem{spec};
  const Solution solution = solved(problem);
  expect_counts_add_up(solution);
  EXPECT_EQ(count(solution, "designs"), 9.0 + 81.0 + 729.0 + 6561.0);
  // Eight types go on, one ends: 8^(n - 1) sequences of n modules are complete.
  EXPECT_EQ(count(solution, "designs") - count(solution, "connectors") - count(solution, "completeness"),
            1.0 + 8.0 + 64.0 + 512.0);
  Meter meter;
  const Solution reference = Enumerate{}.solve(problem, meter, Rng{1});
  EXPECT_EQ(solution.stop, reference.stop);
  EXPECT_EQ(solution.evaluation.attempt.achieved, reference.evaluation.attempt.achieved);
  EXPECT_EQ(solution.evaluation.score, reference.evaluation.score);
}

TEST(Eliminate, ResumesWithinASequence) {
  const test::TemporaryFolder folder;
  const Stacks problem{
      {.library = blocks({true, true}), .values = {2.0, 1.0}, .toll = 0.5, .goal = 2, .max_modules = 4}};
  testing::expect_resumable_contract(Eliminate{{.grid = 20}}, problem, folder.path(), 900);
}

}  // namespace
}  // namespace modsearch
