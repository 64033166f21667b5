#include <gmock/gmock.h>

#include <cmath>
#include <modsearch/baselines/auto_solver.hpp>
#include <modsearch/baselines/branch_and_bound.hpp>
#include <modsearch/baselines/certify/sequence_model_internal.hpp>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/problem/files.hpp>

#include "places.hpp"

namespace modsearch {
namespace {

Solution solved(const DesignProblem& problem, double gap = 1e-4, Budget budget = {}) {
  Meter meter{budget};
  return BranchAndBound{{.gap = gap}}.solve(problem, meter, Rng{0});
}

TEST(BranchAndBound, ProvesTheOptimumOfTheFixedTarget) {
  const Solution solution = solved(*load_problem("seed/fixed"));
  const double best = 350.0 - 5.0 * (0.5 + std::sqrt(1.25) - 0.001);  // hinge, proximal as short as may be
  EXPECT_EQ(solution.stop, StopReason::kOptimal);
  EXPECT_NEAR(solution.evaluation.score, best, 1e-5);
  EXPECT_GE(solution.bound->score, best);
  EXPECT_LE(solution.bound->score, best + 1e-4 * 5.0 * 1.7);
}

TEST(BranchAndBound, AgreesWithTheClosedFormOfOneModule) {
  int compared = 0;
  for (std::uint64_t i = 0; i < 40; ++i) {
    const auto problem = load_problem("seed/random_wide", {11, i});
    const Eigen::Vector3d target = problem->task().goals()[0].position();
    const double distal = std::hypot(target.head<2>().norm(), target.z() - 0.5) - 0.001;
    if (distal < 0.5 || distal > 1.5) continue;
    const double hinge = 350.0 - 5.0 * (0.5 + distal);
    const double r = 0.055;  // of a rotary: proximal t_z - r, distal rho + r
    const bool rotary_fits = target.z() - r > 0.501 && target.head<2>().norm() + r > 0.501;
    if (rotary_fits && target.z() + target.head<2>().norm() < 0.5 + distal + 0.01) continue;
    const Solution solution = solved(*problem);
    EXPECT_EQ(solution.stop, StopReason::kOptimal);
    EXPECT_NEAR(solution.evaluation.score, hinge, 1e-5) << i;
    EXPECT_GE(solution.bound->score, hinge - 1e-9) << i;
    ++compared;
  }
  EXPECT_GT(compared, 15);
}

TEST(BranchAndBound, FindsTwoModulesWhereObstaclesForbidOne) {
  // A roof just above the lowest hinge: the arm has to go round its edge.
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.scene = std::make_shared<Scene>(std::vector<Obstacle>{
      {"roof", {{Box{{1.0, 1.0, 0.06}}, Eigen::Isometry3d{Eigen::Translation3d{0.0, 0.0, 0.67}}}}}});
  spec.task = std::make_shared<GoalTask>(
      "above", std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::ball({0.9, 0.0, 1.3}, 1e-3)}});
  const RobotProblem problem{spec};
  const Solution solution = solved(problem, 0.02);
  ASSERT_TRUE(solution.evaluation.attempt.achieved);
  EXPECT_EQ(solution.design.modules.size(), 2u);
  EXPECT_LT(solution.bound->score, 200.0) << "one module is proved not to do";
  EXPECT_GE(solution.bound->score, solution.evaluation.score);
}

TEST(BranchAndBound, HasABoundAtAnyMoment) {
  const auto problem = load_problem("breakeven/clutter", {3, 1});
  double before = std::numeric_limits<double>::infinity();
  const Solution whole = solved(*problem, 0.01);
  for (const std::int64_t evaluations : {2, 5, 20}) {
    const Solution solution = solved(*problem, 0.01, {.evaluations = evaluations});
    ASSERT_TRUE(solution.bound);
    EXPECT_LE(solution.bound->score, before + 1e-9);
    EXPECT_GE(solution.bound->score, whole.evaluation.score - 1e-9);
    before = solution.bound->score;
  }
}

TEST(BranchAndBound, KeepsToItsTime) {
  const auto problem = load_problem("breakeven/three_goals", {3, 1});
  const Solution solution = solved(*problem, 1e-9, {.seconds = 0.3});
  EXPECT_LE(solution.spent.seconds, 0.3 * 1.05 + 0.02);
}

TEST(BranchAndBound, LeavesWhatItCannotProveToEnumeration) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d{0.0, 0.0, 1.2};
  spec.task = std::make_shared<GoalTask>(
      "pose", std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::with_default_tolerances(pose)}});
  const RobotProblem problem{spec};
  EXPECT_FALSE(BranchAndBound{}.covers(problem));
  const Solution solution = solved(problem, 1e-4, {.evaluations = 50});
  EXPECT_GT(solution.spent.evaluations, 0);
}

// A task that is not known to be goals and nothing else.
class OwnTask final : public Task {
 public:
  [[nodiscard]] std::string_view name() const override { return "own"; }
  [[nodiscard]] std::span<const Goal> goals() const override { return goals_; }

 private:
  std::vector<Goal> goals_{{"1", GoalType::kReach, PoseRegion::ball({0.9, 0.0, 1.0}, 1e-3)}};
};

TEST(BranchAndBound, SaysWhyATaskIsNotCovered) {
  const auto why = [](const RobotProblem& problem) {
    EXPECT_EQ(BranchAndBound{}.covers(problem), !certify::why_not_covered(problem));
    return certify::why_not_covered(problem).value_or("covered");
  };
  const std::filesystem::path tasks = test::source_folder() / "examples" / "tasks";
  EXPECT_EQ(why(*load_problem((tasks / "placed_base.json").string())), "the place of the base is part of the design");
  EXPECT_EQ(why(*load_problem((tasks / "moving.json").string())), "an obstacle moves");
  EXPECT_EQ(why(*load_problem((tasks / "follow.json").string())), "its task has trajectories, pauses or returns");
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  EXPECT_EQ(why(RobotProblem{spec}), "covered");
  spec.task = std::make_shared<OwnTask>();
  EXPECT_EQ(why(RobotProblem{spec}), "its task may be more than goals to reach");
}

TEST(BranchAndBound, RefusesGapsOutOfRange) {
  EXPECT_THROW(BranchAndBound{{.gap = 0.0}}, std::invalid_argument);
  EXPECT_THROW(BranchAndBound{{.gap = 1.5}}, std::invalid_argument);
  EXPECT_THROW((BranchAndBound{{.boxes = -1}}), std::invalid_argument);
}

TEST(AutoSolver, ProvesWhatIsCheapToProve) {
  Meter meter;
  const Solution solution = AutoSolver{}.solve(*load_problem("seed/fixed"), meter, Rng{0});
  EXPECT_EQ(solution.stop, StopReason::kOptimal);
  EXPECT_THAT(solution.reason, testing::HasSubstr("then branch-and-bound: none scores above 341.915"));
}

// Thousands of sequences: gone through as long as that finds something, else drawn by what they promise.
TEST(AutoSolver, GoesOnWithPosesFirstWhereSequencesShowNothing) {
  Meter found{{.evaluations = 1000}};
  EXPECT_THAT(AutoSolver{}.solve(*load_problem("breakeven/two_goals", {1, 0}), found, Rng{0}).reason,
              testing::Not(testing::HasSubstr("then pose-first")));
  Meter nothing{{.evaluations = 1000}};
  EXPECT_THAT(AutoSolver{}.solve(*load_problem("workshop/reach", {0, 1}), nothing, Rng{0}).reason,
              testing::HasSubstr("then pose-first"));
}

// A hundred thousand local optimisations, and none that beats a bound.
TEST(SlowBranchAndBound, IsBeatenByNoSolver) {
  struct Family {
    const char* id;
    std::uint64_t instances;
    int starts;
    double gap;
  };
  std::int64_t starts = 0;
  for (const Family& family :
       {Family{"seed/random_wide", 20, 131, 1e-4}, Family{"seed/random_obstacles", 20, 131, 1e-4},
        Family{"breakeven/short", 8, 131, 1e-3}, Family{"breakeven/two_goals", 8, 131, 1e-3},
        Family{"breakeven/clutter", 8, 131, 1e-3}}) {
    for (std::uint64_t i = 0; i < family.instances; ++i) {
      const auto problem = load_problem(family.id, {5, i});
      const Solution proved = solved(*problem, family.gap, {.seconds = 20.0});
      ASSERT_TRUE(proved.bound);
      // Every sequence of up to two modules on its own, whatever its bound.
      std::vector<std::vector<int>> sequences;
      for (int a = 0; a < 3; ++a) {
        sequences.push_back({a});
        for (int b = 0; b < 3; ++b) sequences.push_back({a, b});
      }
      Meter meter{{.evaluations = 1'000'000'000}};
      for (const std::vector<int>& types : sequences) {
        const std::unique_ptr<SmoothProgram> program = problem->relax(types);
        for (int s = 0; s < family.starts; ++s) {
          const InnerResult result = minimise(Inner::kOwn, *program, program->start(s), {}, meter);
          ++starts;
          if (!(result.violation <= 1e-9)) continue;
          const Evaluation evaluation = problem->evaluate(program->design(result.v));
          if (evaluation.attempt.achieved) {
            EXPECT_LE(evaluation.score, proved.bound->score) << family.id << ' ' << i;
          }
        }
      }
    }
  }
  EXPECT_GE(starts, 100'000);
}

}  // namespace
}  // namespace modsearch
