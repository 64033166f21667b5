#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <modsearch/baselines/design_moves_internal.hpp>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/problem/files.hpp>
#include <set>

namespace modsearch {
namespace {

TEST(ChangedSequence, GivesAValidDesignThatDiffersByOneModule) {
  const auto problem = load_problem("seed/fixed");
  Rng rng{1};
  for (int i = 0; i < 1000; ++i) {
    const Design before = random_design(*problem, rng);
    const Design after = changed_sequence(*problem, before, rng);
    EXPECT_NO_THROW(check(problem->library(), after));
    ASSERT_LT(static_cast<int>(after.modules.size()), problem->max_modules());
    ASSERT_GE(after.modules.size(), 1u);
    const auto n = static_cast<int>(before.modules.size());
    EXPECT_LE(std::abs(static_cast<int>(after.modules.size()) - n), 1);
    int kept = 0;  // modules of `before` that are still there, wherever
    for (const Placement& placement : before.modules) {
      kept += static_cast<int>(std::count(after.modules.begin(), after.modules.end(), placement));
    }
    EXPECT_GE(kept, n - 1);
  }
}

TEST(ChangedSequence, ReachesEveryNeighbourOfADesign) {
  const auto problem = load_problem("seed/fixed");
  Rng rng{2};
  const Design two{{random_placement(problem->library(), 0, rng), random_placement(problem->library(), 1, rng)}};
  std::set<std::vector<int>> sequences;
  for (int i = 0; i < 1000; ++i) sequences.insert(changed_sequence(*problem, two, rng).types());
  // One removed: 0, 1. Swapped: 10. Replaced: 00 01 02 11 21. Inserted: x01, 0x1, 01x with x = 0, 1, 2, two of them
  // twice.
  EXPECT_EQ(sequences.size(), 2u + 1u + 5u + 7u);
}

TEST(Mend, DropsWhatComesTooLate) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.max_modules = 3;
  const RobotProblem problem{spec};
  Rng rng{3};
  Design design;
  for (int i = 0; i < 5; ++i) design.modules.push_back(random_placement(problem.library(), 1, rng));
  const Design before = design;
  mend(problem, design, rng);
  EXPECT_EQ(design, before.prefix(2));
}

// The seed library with a hand: a link whose far connector is the tool's.
RobotProblem with_hand() {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  std::vector<ModuleType> modules{spec.library->base()};
  for (int k = 0; k < spec.library->n_types(); ++k) modules.push_back(spec.library->type(k));
  ModuleType hand = spec.library->type(spec.library->find("link").value());
  hand.id = "hand";
  hand.bodies.back().connectors.back().type = "eef";
  modules.push_back(hand);
  spec.library = std::make_shared<const ModuleLibrary>("with a hand", std::move(modules));
  spec.max_modules = 4;
  return RobotProblem{std::move(spec)};
}

TEST(Mend, GivesEveryDesignItsEndEffector) {
  const RobotProblem problem = with_hand();
  const int hand = problem.library().find("hand").value();
  Rng rng{4};
  for (int i = 0; i < 500; ++i) {
    Design design;
    const int n = rng.index(6);
    for (int module = 0; module < n; ++module) {
      design.modules.push_back(random_placement(problem.library(), rng.index(problem.library().n_types()), rng));
    }
    mend(problem, design, rng);
    ASSERT_FALSE(design.modules.empty());
    EXPECT_EQ(design.modules.back().type, hand);
    EXPECT_TRUE(problem.library().complete(design.types()));
    EXPECT_NO_THROW((void)problem.evaluate(design));
    EXPECT_TRUE(problem.library().complete(changed_sequence(problem, design, rng).types()));
  }
}

}  // namespace
}  // namespace modsearch
