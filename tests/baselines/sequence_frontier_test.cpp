#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <modsearch/baselines/sequence_frontier.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/robot_problem.hpp>
#include <set>

#include "baselines/tiny_problems.hpp"

namespace modsearch {
namespace {

using testing::blocks;
using testing::Stacks;

std::vector<SequenceFrontier::Sequence> all_of(SequenceFrontier& frontier) {
  const Meter meter;
  std::vector<SequenceFrontier::Sequence> all;
  while (!frontier.exhausted()) {
    if (auto sequence = frontier.next(meter)) all.push_back(*std::move(sequence));
  }
  return all;
}

TEST(SequenceFrontier, GivesEverySequenceOnceInFallingOrderOfItsBound) {
  const Stacks problem{{.library = blocks({false, true, false}), .values = {1.0, 3.0, 2.5}, .toll = 2.0}};
  SequenceFrontier frontier{problem};
  const auto all = all_of(frontier);
  std::set<std::vector<int>> different;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].bound, problem.optimism(all[i].types).score);
    if (i > 0) {
      EXPECT_LE(all[i].bound, all[i - 1].bound);
    }
    different.insert(all[i].types);
  }
  EXPECT_EQ(all.size(), 120U);  // 3 + 9 + 27 + 81
  EXPECT_EQ(different.size(), 120U);
}

TEST(SequenceFrontier, MissesNoneWhereMemoryIsShort) {
  const Stacks problem{{.library = blocks({false, true, false}), .values = {1.0, 3.0, 2.5}, .toll = 2.0}};
  SequenceFrontier frontier{problem, 5};
  std::set<std::vector<int>> different;
  const Meter meter;
  while (!frontier.exhausted()) {
    const double bound = frontier.bound();
    if (const auto sequence = frontier.next(meter)) {
      EXPECT_LE(sequence->bound, bound) << "the bound of what is to come covers it";
      different.insert(sequence->types);
    }
  }
  EXPECT_EQ(different.size(), 120U);
}

// The bound of a robot's prefix covers every continuation: as long as allowed, parameters included.
TEST(SequenceFrontier, OfARobotNeverBoundsASequenceBelowItsOwnOptimism) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.max_modules = 5;
  spec.task = std::make_shared<GoalTask>(
      "far", std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::ball({0.0, 4.0, 4.0}, 1e-3)}});
  const RobotProblem problem{spec};
  SequenceFrontier frontier{problem};
  const auto all = all_of(frontier);
  int possible = 0;
  for (int n = 1; n < 5; ++n) {
    std::vector<int> types(static_cast<std::size_t>(n), 0);
    const int count = static_cast<int>(std::pow(3, n));
    for (int i = 0; i < count; ++i) {
      int rest = i;
      for (int& k : types) {
        k = rest % 3;
        rest /= 3;
      }
      const double bound = problem.optimism(types).score;
      if (bound == -std::numeric_limits<double>::infinity()) continue;
      ++possible;
      for (int m = 0; m <= n; ++m) {
        EXPECT_GE(problem.optimism_of_prefix(std::span{types}.first(static_cast<std::size_t>(m)), n).score,
                  bound - 1e-9);
      }
    }
  }
  EXPECT_EQ(static_cast<int>(all.size()), possible);
  for (std::size_t i = 1; i < all.size(); ++i) EXPECT_LE(all[i].bound, all[i - 1].bound + 1e-9);
}

}  // namespace
}  // namespace modsearch
