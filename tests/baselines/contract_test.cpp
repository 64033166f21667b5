#include <gtest/gtest.h>

#include <modsearch/baselines/auto_solver.hpp>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/problem/files.hpp>

#include "contracts/problem_contract.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

// A user's problem: no smooth program, no bounds; as high as its modules are long, and NaN for some designs.
class Tower final : public DesignProblem {
 public:
  explicit Tower(bool with_nan) : library_{load_library("seed")}, with_nan_{with_nan} {}
  [[nodiscard]] std::string name() const override { return with_nan_ ? "tower with holes" : "tower"; }
  [[nodiscard]] const ModuleLibrary& library() const override { return *library_; }
  [[nodiscard]] int max_modules() const override { return 5; }
  [[nodiscard]] Eigen::VectorXd context() const override { return Eigen::VectorXd::Zero(1); }

 private:
  [[nodiscard]] Evaluation do_evaluate(const Design& design, Fidelity) const override {
    Evaluation evaluation;
    evaluation.score = design.parameters().sum();
    evaluation.attempt.achieved = !design.modules.empty();
    if (with_nan_ && design.modules.size() % 2 == 0) evaluation.score = std::numeric_limits<double>::quiet_NaN();
    return evaluation;
  }
  std::shared_ptr<const ModuleLibrary> library_;
  bool with_nan_;
};

TEST(ProblemContract, HoldsForTheReferenceScenariosAtEveryLevel) {
  for (const std::string& id : builtin_problems()) {
    const auto problem = load_problem(id, {5, 1});
    testing::expect_problem_contract(*problem);
    for (const Level level : {Level::kNone, Level::kPostureSelf}) {
      testing::expect_problem_contract(problem->with_level(level));
    }
  }
}

TEST(ProblemContract, HoldsForAUsersProblem) { testing::expect_problem_contract(Tower{false}); }

TEST(SolverContract, HoldsForEverySolverOnEveryKindOfProblem) {
  std::vector<std::unique_ptr<Solver>> solvers;
  solvers.push_back(std::make_unique<RandomSearch>());
  solvers.push_back(std::make_unique<AutoSolver>());
  for (const Inner inner : {Inner::kOwn, Inner::kIpopt, Inner::kSlsqp, Inner::kCobyla, Inner::kCeres}) {
    solvers.push_back(std::make_unique<PerSequence>(PerSequenceOptions{.inner = inner, .starts = 2}));
  }
  const auto fixed = load_problem("seed/fixed");
  const auto obstacles = load_problem("seed/random_obstacles", {5, 2});
  const Tower tower{false};
  for (const auto& solver : solvers) {
    for (const DesignProblem* problem :
         {static_cast<const DesignProblem*>(fixed.get()), static_cast<const DesignProblem*>(obstacles.get()),
          static_cast<const DesignProblem*>(&tower)}) {
      testing::expect_solver_contract(*solver, *problem);
    }
  }
}

TEST(SolverContract, SearchesResumeWhereTheyWereCutOff) {
  const test::TemporaryFolder folder;
  const Tower tower{true};
  testing::expect_resumable_contract(RandomSearch{}, tower, folder.path());
}

TEST(SolverContract, SurvivesScoresThatAreNotNumbers) {
  const Tower holes{true};
  Meter meter{{.evaluations = 200}};
  const Solution solution = RandomSearch{}.solve(holes, meter, Rng{1});
  EXPECT_GT(solution.spent.failed, 50);
  EXPECT_TRUE(std::isfinite(solution.evaluation.score));
  EXPECT_TRUE(solution.evaluation.attempt.achieved);
}

// What every Task promises, for the one that files describe: goals, features of fixed length, an attempt that is a
// function.
TEST(TaskContract, HoldsForTheTasksOfTheReferenceScenarios) {
  for (const std::string& id : builtin_problems()) {
    const auto problem = load_problem(id);
    const Task& task = problem->task();
    ASSERT_FALSE(task.goals().empty());
    EXPECT_EQ(task.features().size(), load_problem(id, {1, 1})->task().features().size());
    EXPECT_TRUE(task.features().allFinite());
    const std::vector<int> types{problem->library().find("hinge").value()};
    const Arm arm = problem->chain(types).at(Eigen::Vector2d{0.9, 1.1});
    const Attempt once = task.attempt(arm, problem->scene(), {});
    const Attempt again = task.attempt(arm, problem->scene(), {});
    EXPECT_EQ(once.postures, again.postures);
    EXPECT_EQ(once.goal_error, again.goal_error);
    EXPECT_EQ(once.postures.rows(), static_cast<Eigen::Index>(task.goals().size()));
    EXPECT_EQ(once.achieved, once.why == Failure::kNone);
    for (Eigen::Index j = 0; j < once.postures.cols(); ++j) {
      EXPECT_LE(std::abs(once.postures(0, j)), arm.chain().upper_limits()[j]);
    }
  }
}

}  // namespace
}  // namespace modsearch
