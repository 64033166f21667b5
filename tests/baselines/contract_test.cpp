#include <gtest/gtest.h>

#include <chrono>
#include <modsearch/baselines/annealing.hpp>
#include <modsearch/baselines/auto_solver.hpp>
#include <modsearch/baselines/branch_and_bound.hpp>
#include <modsearch/baselines/cma_es.hpp>
#include <modsearch/baselines/eliminate.hpp>
#include <modsearch/baselines/enumerate.hpp>
#include <modsearch/baselines/genetic_algorithm.hpp>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/baselines/pose_first.hpp>
#include <modsearch/baselines/refined.hpp>
#include <modsearch/baselines/tree_search.hpp>
#include <modsearch/problem/files.hpp>
#include <thread>

#include "contracts/problem_contract.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

enum class Holes { kNone, kNan, kThrow };

// A user's problem: no smooth program, no bounds; as high as its modules are long, and it fails for some designs.
class Tower final : public DesignProblem {
 public:
  explicit Tower(Holes holes) : library_{load_library("seed")}, holes_{holes} {}
  [[nodiscard]] std::string name() const override { return "tower"; }
  [[nodiscard]] const ModuleLibrary& library() const override { return *library_; }
  [[nodiscard]] int max_modules() const override { return 5; }
  [[nodiscard]] Eigen::VectorXd context() const override { return Eigen::VectorXd::Zero(1); }

 private:
  [[nodiscard]] Evaluation do_evaluate(const Design& design, Fidelity) const override {
    Evaluation evaluation;
    evaluation.score = design.parameters().sum();
    evaluation.attempt.achieved = !design.modules.empty();
    const bool hole = holes_ != Holes::kNone && design.modules.size() % 2 == 0;
    if (hole && holes_ == Holes::kThrow) throw std::runtime_error("an even number of modules");
    if (hole) evaluation.score = std::numeric_limits<double>::quiet_NaN();
    return evaluation;
  }
  std::shared_ptr<const ModuleLibrary> library_;
  Holes holes_;
};

std::vector<std::unique_ptr<SteppedSolver>> stepped_solvers() {
  std::vector<std::unique_ptr<SteppedSolver>> solvers;
  solvers.push_back(std::make_unique<RandomSearch>());
  solvers.push_back(std::make_unique<GeneticAlgorithm>());
  solvers.push_back(std::make_unique<GeneticAlgorithm>(GeneticOptions{.population = 10, .polish = 0}));
  solvers.push_back(std::make_unique<CmaEs>());
  solvers.push_back(std::make_unique<CmaEs>(CmaEsOptions{.space = CmaEsOptions::Space::kPadded}));
  solvers.push_back(std::make_unique<SimulatedAnnealing>());
  solvers.push_back(std::make_unique<PerSequence>(PerSequenceOptions{.starts = 2}));
  solvers.push_back(std::make_unique<Enumerate>(EnumerateOptions{.continuous = {.starts = 2}}));
  solvers.push_back(std::make_unique<Eliminate>(EliminateOptions{.grid = 2}));
  solvers.push_back(std::make_unique<PoseFirst>());
  solvers.push_back(std::make_unique<TreeSearch>());
  solvers.push_back(std::make_unique<TreeSearch>(TreeSearchOptions{.rollout = false, .polish = 0}));
  solvers.push_back(std::make_unique<BranchAndBound>());
  solvers.push_back(std::make_unique<AutoSolver>());
  return solvers;
}

TEST(ProblemContract, HoldsForTheBuiltInProblemsAtEveryLevel) {
  for (const std::string& id : builtin_problems()) {
    const auto problem = load_problem(id, {5, 1});
    testing::expect_problem_contract(*problem);
    for (const Level level : {Level::kNone, Level::kPostureSelf}) {
      testing::expect_problem_contract(problem->with_level(level));
    }
  }
}

TEST(ProblemContract, HoldsForAUsersProblem) { testing::expect_problem_contract(Tower{Holes::kNone}); }

TEST(SolverContract, HoldsForEverySolverOnEveryKindOfProblem) {
  std::vector<std::unique_ptr<Solver>> solvers;
  for (auto& solver : stepped_solvers()) solvers.push_back(std::move(solver));
  solvers.push_back(std::make_unique<Refined>(std::make_shared<PerSequence>(PerSequenceOptions{.starts = 1}),
                                              PerSequenceOptions{.starts = 2}));
  for (const Inner inner : {Inner::kIpopt, Inner::kSlsqp, Inner::kCobyla, Inner::kCeres}) {
    solvers.push_back(std::make_unique<PerSequence>(PerSequenceOptions{.inner = inner, .starts = 2}));
  }
  // Methods that count evaluations of the program get few: the contract is not about what they find.
  for (const Inner inner : {Inner::kDirect, Inner::kCrs2, Inner::kIsres, Inner::kMlsl}) {
    PerSequenceOptions options{.inner = inner, .starts = 2};
    options.inner_options.max_evaluations = 300;
    solvers.push_back(std::make_unique<PerSequence>(options));
  }
  const auto fixed = load_problem("seed/fixed");
  const auto obstacles = load_problem("seed/random_obstacles", {5, 2});
  const Tower tower{Holes::kNone};
  for (const auto& solver : solvers) {
    for (const DesignProblem* problem :
         {static_cast<const DesignProblem*>(fixed.get()), static_cast<const DesignProblem*>(obstacles.get()),
          static_cast<const DesignProblem*>(&tower)}) {
      testing::expect_solver_contract(*solver, *problem);
    }
  }
}

TEST(SolverContract, SearchesResumeWhereTheyWereCutOff) {
  const Tower tower{Holes::kNan};
  const auto wide = load_problem("seed/random_wide", {5, 2});
  for (const auto& solver : stepped_solvers()) {
    const test::TemporaryFolder tower_folder, wide_folder;
    testing::expect_resumable_contract(*solver, tower, tower_folder.path(), 200);
    testing::expect_resumable_contract(*solver, *wide, wide_folder.path(), 200);
  }
}

// Without a smooth program per-sequence has nothing to do, and pose-first without poses.
bool needs_programs(const Solver& solver) {
  return solver.name().starts_with("per-sequence") || solver.name() == "pose-first";
}

TEST(SolverContract, SurvivesProblemsThatFail) {
  for (const auto& solver : stepped_solvers()) {
    if (needs_programs(*solver)) continue;
    for (const Holes holes : {Holes::kNan, Holes::kThrow}) {
      SCOPED_TRACE(solver->name());
      Meter meter{{.evaluations = 200}};
      const Solution solution = solver->solve(Tower{holes}, meter, Rng{1});
      EXPECT_GT(solution.spent.failed, 0);
      EXPECT_EQ(meter.first_failure(),
                holes == Holes::kThrow ? "an even number of modules" : "the score is not a number");
      EXPECT_TRUE(std::isfinite(solution.evaluation.score));
      EXPECT_TRUE(solution.evaluation.attempt.achieved);
      EXPECT_EQ(solution.design.modules.size() % 2, 1u);
    }
  }
}

TEST(SolverContract, StopsAtTheTargetScore) {
  for (const auto& solver : stepped_solvers()) {
    if (needs_programs(*solver)) continue;
    SCOPED_TRACE(solver->name());
    Meter meter{{.evaluations = 2000, .target_score = 2.5}};  // one module in two is 3 m high at most
    const Solution solution = solver->solve(Tower{Holes::kNone}, meter, Rng{1});
    EXPECT_EQ(solution.stop, StopReason::kTargetScore);
    EXPECT_GE(solution.evaluation.score, 2.5);
    EXPECT_EQ(solution.spent.evaluations, meter.trace().back().evaluations) << "and at once";
  }
}

// Seconds and Ctrl-C reach a search the same way: the meter says stop, wherever the search is.
TEST(SolverContract, HearsTheStopWithinOneEvaluation) {
  const auto obstacles = load_problem("seed/random_obstacles", {5, 2});
  for (const auto& solver : stepped_solvers()) {
    SCOPED_TRACE(solver->name());
    for (const std::int64_t last : {1, 2, 7, 8}) {
      std::stop_source source;
      std::int64_t program_evaluations = 0;
      Meter meter{{},
                  [&](const Meter& m) {
                    if (m.progress().evaluations < last) return;
                    source.request_stop();
                    program_evaluations = m.progress().program_evaluations;
                  },
                  source.get_token()};
      const Solution solution = solver->solve(*obstacles, meter, Rng{1});
      EXPECT_LE(solution.spent.evaluations, last);
      if (solution.spent.evaluations < last) continue;  // was over before
      EXPECT_EQ(solution.spent.program_evaluations, program_evaluations);
      EXPECT_EQ(solution.stop, StopReason::kInterrupted);
    }
  }
}

// An evaluation that takes longer than all the time there is: the time is up at the next question.
TEST(SolverContract, EndsATaskThatIsTooSlowForItsBudgetAfterOneEvaluation) {
  class Slow final : public DesignProblem {
   public:
    [[nodiscard]] std::string name() const override { return "slow"; }
    [[nodiscard]] const ModuleLibrary& library() const override { return *library_; }
    [[nodiscard]] int max_modules() const override { return 5; }
    [[nodiscard]] Eigen::VectorXd context() const override { return Eigen::VectorXd::Zero(1); }

   private:
    [[nodiscard]] Evaluation do_evaluate(const Design&, Fidelity) const override {
      const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds{20};
      while (std::chrono::steady_clock::now() < end) std::this_thread::yield();
      Evaluation evaluation;
      evaluation.score = 1.0;
      return evaluation;
    }
    std::shared_ptr<const ModuleLibrary> library_ = load_library("seed");
  };
  for (const auto& solver : stepped_solvers()) {
    SCOPED_TRACE(solver->name());
    Meter meter{{.seconds = 0.02}};
    const Solution solution = solver->solve(Slow{}, meter, Rng{1});
    EXPECT_LE(solution.spent.evaluations, 1);
    EXPECT_EQ(solution.stop, StopReason::kSeconds);
  }
}

TEST(SolverContract, ProvesAtOnceThatNothingReachesTooFar) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.task = std::make_shared<GoalTask>(
      "far", std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::ball({0.0, 20.0, 20.0}, 1e-3)}});
  const RobotProblem problem{spec};
  for (const auto& solver : stepped_solvers()) {
    if (solver->name() == "random") continue;  // looks at no bounds
    SCOPED_TRACE(solver->name());
    Meter meter;
    const Solution solution = solver->solve(problem, meter, Rng{0});
    EXPECT_EQ(solution.stop, StopReason::kUnreachable);
    EXPECT_NE(solution.reason.find("28.28 m away"), std::string::npos) << solution.reason;
    EXPECT_LE(solution.spent.evaluations, 1);
  }
}

// Task 6 of the generated family: every gripper lies in a box at goal 3.
TEST(SolverContract, EndsAtOnceWhereTheProblemIsProvedInfeasible) {
  const auto problem = load_problem("whitman/3g_3o", {.seed = 0, .index = 6});
  ASSERT_TRUE(problem->infeasible());
  for (const auto& solver : stepped_solvers()) {
    SCOPED_TRACE(solver->name());
    Meter meter;
    const Solution solution = solver->solve(*problem, meter, Rng{0});
    EXPECT_EQ(solution.stop, StopReason::kUnreachable);
    EXPECT_EQ(solution.reason, "proved infeasible: " + problem->infeasible()->reason);
    EXPECT_EQ(solution.spent.evaluations, 1);
    EXPECT_FALSE(solution.evaluation.attempt.achieved);
  }
}

// What every Task promises, for the one that files describe: goals, features of fixed length, an attempt that is a
// function.
TEST(TaskContract, HoldsForTheTasksOfTheReferenceScenarios) {
  for (const char* id : {"seed/fixed", "seed/random_narrow", "seed/random_obstacles", "seed/random_wide"}) {
    const auto problem = load_problem(id);
    const Task& task = problem->task();
    ASSERT_FALSE(task.goals().empty());
    EXPECT_EQ(task.features().size(), load_problem(id, {1, 1})->task().features().size());
    EXPECT_TRUE(task.features().allFinite());
    const std::vector<int> types{problem->library().find("hinge").value()};
    const std::shared_ptr<const Chain> chain = problem->chain(types);
    const Arm arm = chain->at(Eigen::Vector2d{0.9, 1.1});
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
