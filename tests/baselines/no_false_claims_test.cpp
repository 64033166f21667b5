#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/baselines/auto_solver.hpp>
#include <modsearch/baselines/branch_and_bound.hpp>
#include <modsearch/baselines/eliminate.hpp>
#include <modsearch/baselines/enumerate.hpp>
#include <modsearch/baselines/tree_search.hpp>
#include <modsearch/problem/robot_problem.hpp>
#include <numbers>

#include "problem/end_tasks.hpp"

// Tasks that have a solution by construction: an arm and its posture come first, goal and obstacles are put around
// them. Whatever a search does not find, it must not say that there is none, or that none is better.
namespace modsearch {
namespace {

using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;
constexpr double kRadius = 0.04;  // of every link [m]

Eigen::Isometry3d along_z(double z) { return Eigen::Isometry3d{Eigen::Translation3d{0.0, 0.0, z}}; }

// A half turn or a quarter turn of the axes, or any rotation.
Eigen::Matrix3d some_rotation(Rng& rng) {
  if (rng.index(3) == 0) return test::random_rotation(rng);
  const Eigen::Vector3d axis = Eigen::Vector3d::Unit(rng.index(3));
  return Eigen::AngleAxisd{0.5 * kPi * rng.index(4), axis}.toRotationMatrix();
}

ModuleBody link(const std::string& id, double length) {
  ModuleBody body;
  body.id = id;
  body.mass = AffineScalar{1.0 + length};
  AffineShape shape;
  shape.kind = AffineShape::Kind::kCylinder;
  shape.size = {AffineScalar{kRadius}, AffineScalar{length}};
  body.collision.push_back({shape, ParametricPose{along_z(0.5 * length)}});
  return body;
}

Connector connector(const char* id, const Eigen::Isometry3d& X_BC, Gender gender, const char* type) {
  return {id, AffinePose{X_BC}, gender, type, {1.0}};
}

// Into a body its connectors point away from it: the one at its beginning downwards.
Eigen::Isometry3d downwards() { return Eigen::Isometry3d{Eigen::AngleAxisd{kPi, Eigen::Vector3d::UnitX()}}; }

// Links in a row with a joint between neighbours; the joints stand askew, and most have limits.
ModuleType module_of(const std::string& id, int n_joints, Rng& rng) {
  ModuleType module;
  module.id = module.name = id;
  module.cost = rng.uniform(0.0, 2.0);
  std::vector<double> lengths;
  for (int b = 0; b <= n_joints; ++b) {
    lengths.push_back(rng.uniform(0.1, 0.4));
    module.bodies.push_back(link("link" + std::to_string(b), lengths.back()));
  }
  module.bodies.front().connectors.push_back(connector("in", downwards(), Gender::kFemale, "arm"));
  module.bodies.back().connectors.push_back(connector("out", along_z(lengths.back()), Gender::kMale, "arm"));
  for (int j = 0; j < n_joints; ++j) {
    ModuleJoint joint;
    joint.joint.name = "joint" + std::to_string(j);
    const bool endless = rng.index(4) == 0;
    joint.joint.type = endless ? JointType::kContinuous : JointType::kRevolute;
    const double reach = rng.uniform(0.8, kPi);
    if (!endless) {
      joint.joint.lower = -reach;
      joint.joint.upper = rng.index(3) == 0 ? 0.3 : reach;
    }
    joint.parent = j;
    joint.child = j + 1;
    Eigen::Isometry3d X = along_z(lengths[static_cast<std::size_t>(j)]);
    X.linear() = some_rotation(rng);
    joint.X_PJ = AffinePose{X};
    joint.X_JC = AffinePose{Eigen::Isometry3d::Identity()};
    module.joints.push_back(joint);
  }
  return module;
}

std::shared_ptr<const ModuleLibrary> random_library(Rng& rng) {
  ModuleType base;
  base.id = base.name = "base";
  base.bodies.resize(1);
  base.bodies[0].id = "foot";
  base.bodies[0].connectors = {connector("ground", downwards(), Gender::kFemale, "base"),
                               connector("out", along_z(0.0), Gender::kMale, "arm")};
  std::vector<ModuleType> modules{base};
  const int n_types = 2 + rng.index(2);
  for (int k = 0; k < n_types; ++k) modules.push_back(module_of("m" + std::to_string(k), 1 + rng.index(2), rng));
  return std::make_shared<const ModuleLibrary>("random", std::move(modules));
}

struct Planted {
  RobotProblem problem;
  Design design;
  Eigen::MatrixXd posture;  // [1 x n_joints]
};

// A plate with a square hole around a link of the arm, wider than the link by `gap` on every side.
Obstacle plate_around(const Arm& arm, const Posture& posture, double gap, Rng& rng) {
  const ArmGeometry& geometry =
      arm.geometries()[static_cast<std::size_t>(rng.index(static_cast<int>(arm.geometries().size())))];
  const Eigen::Isometry3d X_WL = posture.frames[static_cast<std::size_t>(geometry.frame)] * geometry.X_FG;
  constexpr double kThick = 0.02;
  constexpr double kWide = 0.6;
  const double half = kRadius + gap;
  Obstacle plate{"plate", {}};
  for (int side = 0; side < 4; ++side) {
    const double away = half + 0.5 * kWide;
    const double angle = 0.5 * kPi * side;
    Eigen::Isometry3d X_LB{Eigen::AngleAxisd{angle, Eigen::Vector3d::UnitZ()}};
    X_LB = X_LB * Eigen::Translation3d{away, 0.0, 0.0};
    plate.shapes.push_back({Box{{kWide, 2.0 * (half + kWide), kThick}}, X_WL * X_LB});
  }
  return plate;
}

std::optional<Planted> planted(Rng& rng) {
  const std::shared_ptr<const ModuleLibrary> library = random_library(rng);
  Design design;
  const int n_modules = 1 + rng.index(3);
  for (int i = 0; i < n_modules; ++i) design.modules.push_back({rng.index(library->n_types()), Parameters{}});
  const Chain chain = library->assemble(design.types());
  const Arm arm = chain.at(Eigen::VectorXd{});
  const Eigen::VectorXd q = test::random_posture(chain, rng);
  const Posture posture = arm.forward(q);

  const bool ball = rng.index(2) == 0;
  Goal goal{
      "goal", GoalType::kReach,
      ball ? PoseRegion::ball(posture.tip.translation(), 1e-3) : PoseRegion::with_default_tolerances(posture.tip)};
  std::vector<Obstacle> obstacles;
  if (rng.index(2) == 0) obstacles.push_back(plate_around(arm, posture, rng.uniform(1e-3, 0.02), rng));

  const Level levels[] = {Level::kNone, Level::kPosture, Level::kPostureSelf, Level::kPath};
  RobotProblemSpec spec;
  spec.name = "planted";
  spec.library = library;
  // The arm may begin where it has to be: then there is a path as well.
  spec.task = std::make_shared<GoalTask>("planted", std::vector<Goal>{goal}, q);
  spec.scene = std::make_shared<Scene>(std::move(obstacles));
  spec.scoring = std::make_shared<WeightedScoring>(
      WeightedScoring::Weights{.reached = 100.0, .distance = 1.0, .mass = 1.0, .cost = 1.0});
  spec.level = levels[rng.index(4)];
  spec.max_modules = 4;
  spec.planner.max_iterations = 100;
  Planted result{RobotProblem{std::move(spec)}, std::move(design), q.transpose()};
  const Evaluation evaluation =
      result.problem.evaluate(result.design, Fidelity::kFull, {.postures = result.posture, .only = true});
  if (!evaluation.attempt.achieved) return std::nullopt;  // the plate cuts another link, or the arm touches itself
  return result;
}

void expect_no_false_claim(int n_tasks, std::uint64_t seed) {
  std::vector<std::unique_ptr<const Solver>> solvers;
  solvers.push_back(std::make_unique<Enumerate>());
  solvers.push_back(std::make_unique<Eliminate>());
  solvers.push_back(std::make_unique<TreeSearch>());
  solvers.push_back(std::make_unique<AutoSolver>());
  solvers.push_back(std::make_unique<BranchAndBound>(BranchAndBoundOptions{.boxes = 300}));
  Rng rng{seed};
  int proved = 0;
  for (int i = 0; i < n_tasks;) {
    const std::optional<Planted> task = planted(rng);
    if (!task) continue;
    ++i;
    const double worth =
        task->problem.evaluate(task->design, Fidelity::kFull, {.postures = task->posture, .only = true}).score;
    for (const std::unique_ptr<const Solver>& solver : solvers) {
      Meter meter{{.evaluations = 400}};
      const Solution solution = solver->solve(task->problem, meter, Rng{seed});
      SCOPED_TRACE(solver->name() + " on task " + std::to_string(i) + ", which ended with: " + solution.reason);
      EXPECT_NE(solution.stop, StopReason::kUnreachable);
      if (solution.bound) {
        EXPECT_GE(solution.bound->score, worth - 1e-9);
      }
      if (solution.stop == StopReason::kOptimal) {
        ++proved;
        const double gap = solution.bound ? std::max(0.0, solution.bound->score - solution.evaluation.score) : 0.0;
        EXPECT_GE(solution.evaluation.score + gap, worth - 1e-9);
      }
      EXPECT_THAT(solution.reason, Not(HasSubstr("proved unreachable")));
    }
  }
  EXPECT_GT(proved, n_tasks / 10) << "where nothing is ever proved, nothing false is either";
}

TEST(NoFalseClaims, AreMadeAgainst150ArmsThatWerePlanted) { expect_no_false_claim(150, 1); }
TEST(SlowNoFalseClaims, AreMadeAgainst2000ArmsThatWerePlanted) { expect_no_false_claim(2000, 2); }

// A bound of somebody else's that is none.
class FlatteringScoring final : public Scoring {
 public:
  [[nodiscard]] std::string_view name() const override { return "flattering"; }
  [[nodiscard]] Terms terms(const Facts& facts) const override {
    Terms terms;
    terms.add(TermId::kReached, facts.achieved ? 10.0 : 0.0);
    return terms;
  }
  [[nodiscard]] double bound(int, double, double) const override { return 5.0; }
  [[nodiscard]] double mass_weight() const override { return 0.0; }
};

TEST(NoFalseClaims, AreMadeOfABoundThatAnAchievedDesignExceeds) {
  Rng rng{5};
  std::optional<Planted> task;
  while (!task || task->problem.spec().level != Level::kNone) task = planted(rng);
  RobotProblemSpec spec = task->problem.spec();
  spec.scoring = std::make_shared<FlatteringScoring>();
  const RobotProblem problem{std::move(spec)};
  Meter meter{{.evaluations = 400}};
  const Solution solution = Enumerate{}.solve(problem, meter, Rng{1});
  ASSERT_TRUE(solution.evaluation.attempt.achieved);
  EXPECT_EQ(solution.stop, StopReason::kExhausted);
  EXPECT_FALSE(solution.bound);
  EXPECT_THAT(solution.reason, HasSubstr("the problem's bound is wrong: it is 5, and an achieved design scores 10"));
}

}  // namespace
}  // namespace modsearch
