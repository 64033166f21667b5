#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/baselines/auto_solver.hpp>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/solvers/verification.hpp>
#include <numbers>

#include "baselines/tiny_problems.hpp"
#include "contracts/problem_contract.hpp"
#include "problem/one_module_optimum.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

Solution solved(const DesignProblem& problem, Inner inner, std::uint64_t seed = 0) {
  Meter meter;
  return PerSequence{{.inner = inner}}.solve(problem, meter, Rng{seed});
}

constexpr std::uint64_t kInstances = 200;

// PROBLEM 5: the optimum of seed/fixed is 350 - 5 (0.5 + sqrt(1.25) - 0.001) = 341.9148.
class PerSequenceWith : public ::testing::TestWithParam<Inner> {};

TEST_P(PerSequenceWith, FindsTheOptimumOfSeedFixed) {
  const auto problem = load_problem("seed/fixed");
  const Solution solution = solved(*problem, GetParam());
  EXPECT_TRUE(solution.evaluation.attempt.achieved);
  EXPECT_EQ(solution.design.modules.size(), 1u);
  EXPECT_GE(solution.evaluation.score, 341.91);
  EXPECT_LE(solution.evaluation.score, 350.0 - 5.0 * (0.5 + std::sqrt(1.25) - 0.001) + 1e-9);
}

TEST_P(PerSequenceWith, GivesEqualAnswersForEqualSeeds) {
  const auto problem = load_problem("seed/random_obstacles", {0, 5});
  EXPECT_EQ(solved(*problem, GetParam(), 3).design, solved(*problem, GetParam(), 3).design);
}

INSTANTIATE_TEST_SUITE_P(LocalMethods, PerSequenceWith,
                         ::testing::Values(Inner::kOwn, Inner::kIpopt, Inner::kSlsqp, Inner::kCobyla, Inner::kCeres),
                         [](const auto& tested) { return std::string{name(tested.param)}; });

struct Quality {
  int one_module = 0;
  int optimal = 0;  // regret to the closed form below 0.01
  double worst = 0.0;
};

Quality quality(const char* scenario, Inner inner) {
  Quality result;
  const ProblemFile file = load_problem_file(scenario);
  for (std::uint64_t i = 0; i < kInstances; ++i) {
    const auto problem = file.instance({2022, i});
    const double best = testing::one_module_optimum(problem->task().goals()[0].position()).score();
    const Solution solution = solved(*problem, inner);
    const double regret = best - solution.evaluation.score;
    result.worst = std::max(result.worst, regret);
    if (solution.evaluation.attempt.achieved && solution.design.modules.size() == 1) ++result.one_module;
    if (solution.evaluation.attempt.achieved && regret < 0.01) ++result.optimal;
    EXPECT_GT(regret, -1e-6) << "better than the closed form: instance " << i;
  }
  return result;
}

TEST(PerSequence, SolvesTwoHundredNarrowInstances) {
  const Quality own = quality("seed/random_narrow", Inner::kOwn);
  EXPECT_EQ(own.one_module, kInstances);
  EXPECT_GE(own.optimal, 198) << "worst regret " << own.worst;
}

TEST(PerSequence, SolvesTwoHundredWideInstances) {
  const Quality own = quality("seed/random_wide", Inner::kOwn);
  EXPECT_EQ(own.one_module, kInstances);
  EXPECT_GE(own.optimal, 198) << "worst regret " << own.worst;
}

TEST(SlowPerSequence, SolvesTwoHundredNarrowInstancesWithIpopt) {
  const Quality ipopt = quality("seed/random_narrow", Inner::kIpopt);
  EXPECT_EQ(ipopt.one_module, kInstances);
  EXPECT_GE(ipopt.optimal, 198) << "worst regret " << ipopt.worst;
}

TEST(SlowPerSequence, SolvesTwoHundredWideInstancesWithIpopt) {
  const Quality ipopt = quality("seed/random_wide", Inner::kIpopt);
  EXPECT_EQ(ipopt.one_module, kInstances);
  EXPECT_GE(ipopt.optimal, 198) << "worst regret " << ipopt.worst;
}

// The best one-module score among obstacles on a fine grid: for each proximal length of a hinge every distal length
// that reaches is within a millimetre of hypot(rho, t_z - p); for a rotary both lengths are given up to the tolerance.
double one_module_reference(const RobotProblem& problem) {
  const Eigen::Vector3d t = problem.task().goals()[0].position();
  const double rho = std::hypot(t.x(), t.y());
  double best = -std::numeric_limits<double>::infinity();
  const auto offer = [&](const char* type, double proximal, double distal) {
    if (proximal < 0.5 || proximal > 1.5 || distal < 0.5 || distal > 1.5) return;
    if (350.0 - 5.0 * (proximal + distal) <= best) return;
    Placement placement{problem.library().find(type).value(), Parameters(2)};
    placement.parameters << proximal, distal;
    const Evaluation evaluation = problem.evaluate({{placement}});
    if (evaluation.attempt.achieved) best = std::max(best, evaluation.score);
  };
  for (int i = 0; i <= 1000; ++i) {
    const double p = 0.5 + 0.001 * i;
    const double d = std::hypot(rho, t.z() - p);
    for (const double off : {-0.000999, -0.0005, 0.0, 0.0005, 0.000999}) {
      offer("hinge", p, d + off);
    }
  }
  for (const double off_p : {-0.0007, 0.0, 0.0007}) {
    for (const double off_d : {-0.0007, 0.0, 0.0007}) offer("rotary", t.z() - 0.055 + off_p, rho + 0.055 + off_d);
  }
  return best;
}

TEST(PerSequence, SolvesTwoHundredInstancesWithObstaclesNearlyAsWellAsBruteForce) {
  const ProblemFile file = load_problem_file("seed/random_obstacles");
  int close = 0;
  int with_reference = 0;
  int by_path = 0;
  for (std::uint64_t i = 0; i < kInstances; ++i) {
    const auto problem = file.instance({2022, i});
    const double reference = one_module_reference(*problem);
    const Solution solution = solved(*problem, Inner::kOwn);
    ASSERT_TRUE(solution.evaluation.attempt.achieved) << i;
    if (std::isfinite(reference)) {
      ++with_reference;
      if (solution.evaluation.score >= reference - 0.1) ++close;
    } else {
      EXPECT_GE(solution.design.modules.size(), 2u) << "a one-module design the grid has missed: instance " << i;
    }
    const Verification verification = verify(*problem, solution.design, {.score = solution.evaluation.score});
    if (verification.level == "path") {
      ++by_path;
    } else {
      EXPECT_FALSE(verification.findings.empty()) << "not verified and no reason given: instance " << i;
    }
  }
  EXPECT_GE(with_reference, 190);
  EXPECT_GE(close, static_cast<int>(std::ceil(0.97 * with_reference)));
  RecordProperty("verified_by_path", by_path);
  std::printf("verified by a path: %d of %d; close to the reference: %d of %d\n", by_path, static_cast<int>(kInstances),
              close, with_reference);
}

TEST(PerSequence, ProvesAtOnceThatATargetBeyondEveryReachIsUnreachable) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.task = std::make_shared<GoalTask>(
      "far", std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::ball({0.0, 20.0, 20.0}, 1e-3)}});
  const RobotProblem problem{spec};
  Meter meter;
  const Solution solution = AutoSolver{}.solve(problem, meter, Rng{0});
  EXPECT_EQ(solution.stop, StopReason::kUnreachable);
  EXPECT_NE(solution.reason.find("28.28 m away"), std::string::npos) << solution.reason;
  EXPECT_LE(solution.spent.evaluations, 1);  // the empty design
  EXPECT_FALSE(solution.evaluation.attempt.achieved);
}

// At (0, 3, 3) the target is 4.24 m away: one module of at most 3 m is not enough, two of the longest are.
TEST(PerSequence, UsesAsManyModulesAsTheDistanceAsksFor) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.task = std::make_shared<GoalTask>(
      "two", std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::ball({0.0, 3.0, 3.0}, 1e-3)}});
  const RobotProblem problem{spec};
  const Solution solution = solved(problem, Inner::kOwn);
  EXPECT_TRUE(solution.evaluation.attempt.achieved);
  EXPECT_EQ(solution.design.modules.size(), 2u);
}

TEST(PerSequence, SolvesTwoGoalsWithOneDesign) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.task = std::make_shared<GoalTask>(
      "both", std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::ball({1.0, 0.0, 1.0}, 1e-3)},
                                {"2", GoalType::kReach, PoseRegion::ball({0.0, 1.2, 0.6}, 1e-3)}});
  const RobotProblem problem{spec};
  const Solution solution = solved(problem, Inner::kOwn);
  EXPECT_TRUE(solution.evaluation.attempt.achieved);
  // One hinge has its tip on a circle about its joint: (1, 1) and (1.2, 0.6) in the meridional plane are equally far
  // from (0, p) for 1 + (1 - p)^2 = 1.44 + (0.6 - p)^2, p = 0.25, too low. Two modules it is.
  EXPECT_EQ(solution.design.modules.size(), 2u);
  const Verification verification = verify(problem, solution.design);
  EXPECT_TRUE(verification.verified);
}

// A circle of radius 0.2 m about a point 0.9 m away, in 73 poses to 2 mm, with the tool pointing down within a cone.
// With the 8 knots of the task's goals the program of two hinges is feasible and its design leaves the circle between
// them.
TEST(PerSequence, FollowsATrajectoryThatItsKnotsAloneDoNotHold) {
  constexpr int kSteps = 72;
  Trajectory circle;
  for (int k = 0; k <= kSteps; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kSteps;
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = Eigen::Vector3d{1.0, -1.0, -1.0}.asDiagonal();
    X.translation() = Eigen::Vector3d{0.9 + 0.2 * std::cos(angle), 0.2 * std::sin(angle), 0.6};
    circle.poses.push_back({X,
                            {{Projection::kRSph, 0.0, 0.002, Eigen::Matrix3d::Identity()},
                             {Projection::kNx, -0.25, 0.25, Eigen::Matrix3d::Identity()},
                             {Projection::kNy, -0.25, 0.25, Eigen::Matrix3d::Identity()}}});
  }
  const FollowStep step = follow("circle", circle, 0);
  RobotProblemSpec spec = load_problem_file("seed/fixed").instance()->spec();
  spec.max_modules = 3;
  spec.task = std::make_shared<GoalTask>(GoalTaskSpec{.name = "circle", .goals = step.goals, .steps = {step.step}});
  const RobotProblem problem{spec};

  const int hinge = problem.library().find("hinge").value();
  const std::vector<int> hinges{hinge, hinge};
  const std::unique_ptr<SmoothProgram> program = problem.relax(hinges);
  Meter meter;
  const InnerResult result = minimise(Inner::kOwn, *program, program->start(0), {.first_penalty = 1e3}, meter);
  EXPECT_EQ(result.status, InnerStatus::kConverged);
  EXPECT_FALSE(problem.evaluate(program->design(result.v)).attempt.reached);

  const Solution best = PerSequence{}.solve(problem, meter, Rng{0});
  EXPECT_TRUE(best.evaluation.attempt.achieved);
  EXPECT_EQ(best.design.types(), hinges);
}

// seed/fixed, but the smooth programs of some sequences do what users' programs do.
class Faulty final : public DesignProblem {
 public:
  enum class Fault { kThrows, kThrowsInside, kIsNotANumber };
  explicit Faulty(Fault fault) : fault_{fault} {}
  [[nodiscard]] std::string name() const override { return "faulty"; }
  [[nodiscard]] const ModuleLibrary& library() const override { return sound_->library(); }
  [[nodiscard]] int max_modules() const override { return 3; }
  [[nodiscard]] Eigen::VectorXd context() const override { return sound_->context(); }
  [[nodiscard]] std::unique_ptr<SmoothProgram> relax(std::span<const int> types, const Relaxation& r) const override {
    if (types.size() != 1 || library().type(types[0]).id != "hinge") return sound_->relax(types, r);
    if (fault_ == Fault::kThrows) throw std::runtime_error("no program for hinges");
    return std::make_unique<Program>(sound_->relax(types, r), fault_ == Fault::kThrowsInside);
  }

 private:
  class Program final : public SmoothProgram {
   public:
    Program(std::unique_ptr<SmoothProgram> sound, bool throws) : sound_{std::move(sound)}, throws_{throws} {
      lower_ = sound_->lower();
      upper_ = sound_->upper();
      row_lower_ = sound_->row_lower();
      row_upper_ = sound_->row_upper();
      balls_ = sound_->balls();
    }
    [[nodiscard]] Design design(const Eigen::VectorXd& v) const override { return sound_->design(v); }

   private:
    void do_evaluate(const Eigen::VectorXd& v, Values& values) override {
      if (throws_) throw std::runtime_error("the program of hinges breaks off");
      sound_->evaluate(v, values);
      values.objective = std::numeric_limits<double>::quiet_NaN();
    }
    [[nodiscard]] Eigen::MatrixXd do_hessian(const Eigen::VectorXd& v, double factor,
                                             const Eigen::VectorXd& m) override {
      return sound_->hessian(v, factor, m);
    }
    std::unique_ptr<SmoothProgram> sound_;
    bool throws_;
  };

  [[nodiscard]] Evaluation do_evaluate(const Design& design, Fidelity fidelity) const override {
    return sound_->evaluate(design, fidelity);
  }
  std::shared_ptr<const DesignProblem> sound_ = load_problem("seed/fixed");
  Fault fault_;
};

// Without a hinge the best is a rotary module: proximal 1 - r, distal 1 + r, both shorter by what a millimetre of
// tolerance gives along their diagonal.
TEST(PerSequence, GoesOnWhereTheProgramOfOneSequenceFails) {
  using Fault = Faulty::Fault;
  const std::pair<Fault, std::string> faults[] = {{Fault::kThrows, "no program for hinges"},
                                                  {Fault::kThrowsInside, "the program of hinges breaks off"},
                                                  {Fault::kIsNotANumber, "the smooth program is not a number"}};
  for (const auto& [fault, what] : faults) {
    for (const Inner inner : {Inner::kOwn, Inner::kSlsqp, Inner::kIpopt}) {
      SCOPED_TRACE(what + ", " + std::string{name(inner)});
      const Faulty problem{fault};
      Meter meter;
      const Solution solution = PerSequence{{.inner = inner}}.solve(problem, meter, Rng{1});
      EXPECT_TRUE(solution.evaluation.attempt.achieved);
      EXPECT_NEAR(solution.evaluation.score, 350.0 - 5.0 * (2.0 - std::sqrt(2.0) * 0.001), 1e-4);
      EXPECT_NE(solution.reason.find("1 of them failed: " + what), std::string::npos) << solution.reason;
      EXPECT_EQ(solution.stop, StopReason::kExhausted) << "nothing is proved of a sequence that failed";
    }
  }
}

TEST(PerSequence, ResumesWhereItWasCutOff) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.max_modules = 4;
  spec.task = std::make_shared<GoalTask>(
      "two", std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::ball({0.0, 3.0, 3.0}, 1e-3)}});
  for (const Inner inner : {Inner::kOwn, Inner::kCrs2}) {
    const test::TemporaryFolder folder;
    testing::expect_resumable_contract(PerSequence{{.inner = inner, .starts = 2}}, RobotProblem{spec}, folder.path(),
                                       10);
  }
}

TEST(PerSequence, StopsAtItsBudgetOfEvaluations) {
  const auto problem = load_problem("seed/fixed");
  Meter meter{{.evaluations = 3}};
  const Solution solution = PerSequence{}.solve(*problem, meter, Rng{0});
  EXPECT_EQ(solution.spent.evaluations, 3);
  EXPECT_EQ(solution.stop, StopReason::kEvaluations);
}

// Stacks have no smooth programs: nothing is optimised, and nothing is said of what was.
TEST(PerSequence, SaysThatAProblemHasNoSmoothPrograms) {
  const testing::Stacks problem{
      {.library = testing::blocks({true, true}), .values = {2.0, 1.0}, .goal = 2, .max_modules = 3}};
  Meter meter{{.evaluations = 100}};
  const Solution solution = PerSequence{}.solve(problem, meter, Rng{1});
  EXPECT_EQ(solution.stop, StopReason::kExhausted);
  EXPECT_NE(solution.reason.find("has a smooth program, so that nothing was optimised"), std::string::npos)
      << solution.reason;
}

}  // namespace
}  // namespace modsearch
