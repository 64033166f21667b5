#include <gtest/gtest.h>

#include <modsearch/baselines/genetic_algorithm.hpp>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/solvers/verification.hpp>

#include "contracts/problem_contract.hpp"
#include "contracts/task_contract.hpp"
#include "places.hpp"

namespace modsearch {
namespace {

std::shared_ptr<const RobotProblem> example(const std::string& name) {
  return load_problem((test::source_folder() / "examples/tasks" / (name + ".json")).string());
}

// One file per kind of task.
class EveryTaskFile : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Kinds, EveryTaskFile,
                         ::testing::Values("follow", "cycle", "any_order", "payload", "placed_base", "moving"),
                         [](const auto& kind) { return std::string{kind.param}; });

TEST_P(EveryTaskFile, KeepsTheContractsOfTasksAndProblems) {
  const auto problem = example(GetParam());
  testing::expect_task_contract(*problem, 4);
  testing::expect_problem_contract(*problem);
}

TEST_P(EveryTaskFile, IsSolvedByOptimisationAndByEvolution) {
  const auto problem = example(GetParam());
  Meter meter{{.evaluations = 2000}}, other{{.evaluations = 3000}};
  const Solution best = PerSequence{{.starts = 4}}.solve(*problem, meter, Rng{0});
  EXPECT_TRUE(best.evaluation.attempt.achieved) << name(best.evaluation.attempt.why);
  const Verification verification = verify(*problem, best.design, {.score = best.evaluation.score});
  EXPECT_TRUE(verification.verified) << (verification.findings.empty() ? "" : verification.findings.front());
  const Solution evolved = GeneticAlgorithm{}.solve(*problem, other, Rng{0});
  EXPECT_TRUE(evolved.evaluation.attempt.achieved) << name(evolved.evaluation.attempt.why);
  std::cout << "    " << to_string(problem->library(), best.design) << " " << best.evaluation.score << ", evolved "
            << evolved.evaluation.score << '\n';
}

// The shoulder of a hinge has to bear ten kilograms a metre away: 98 N m of 60. A rotary's joints are upright and bear
// nothing: the best one module is p = 1 - 0.055, d = 1 + 0.055, either within the tolerance of 1 mm.
TEST(PayloadFile, LeavesTheUprightJoints) {
  const auto problem = example("payload");
  const int hinge = problem->library().find("hinge").value();
  const Evaluation best_hinge = problem->evaluate({{{hinge, Parameters{{0.5, std::sqrt(1.25) - 0.001}}}}});
  EXPECT_TRUE(best_hinge.attempt.reached);
  EXPECT_EQ(best_hinge.attempt.why, Failure::kTorque);
  Meter meter;
  const Solution best = PerSequence{{.starts = 4}}.solve(*problem, meter, Rng{0});
  ASSERT_EQ(best.design.modules.size(), 1U);
  EXPECT_EQ(problem->library().type(best.design.modules[0].type).id, "rotary");
  EXPECT_NEAR(best.evaluation.score, 350.0 - 5.0 * 2.0, 0.01);
}

// The base of placed_base.json may come half a metre closer: two points at 1.4 m need shorter arms for it.
TEST(PlacedBaseFile, ScoresMoreThanABaseThatStays) {
  const auto placed = example("placed_base");
  Meter meter;
  const Solution best = PerSequence{{.starts = 4}}.solve(*placed, meter, Rng{0});
  ASSERT_TRUE(best.evaluation.attempt.achieved);
  RobotProblemSpec spec = placed->spec();
  spec.library = load_library("seed");
  spec.placed_base = false;
  const RobotProblem fixed{spec};
  Meter other;
  const Solution there = PerSequence{{.starts = 4}}.solve(fixed, other, Rng{0});
  EXPECT_GT(best.evaluation.score, there.evaluation.score + 1.0);
}

}  // namespace
}  // namespace modsearch
