#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/problem/task_program.hpp>
#include <numbers>

namespace modsearch {
namespace {

constexpr double kPi = std::numbers::pi;

Eigen::VectorXd random_point(const SmoothProgram& program, Rng& rng) {
  Eigen::VectorXd v(program.n_variables());
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = rng.uniform(program.lower()[i], program.upper()[i]);
  return v;
}

// Central differences of rows and objective against the exact first derivatives at random points. Rows of clearance have
// kinks (two faces equally close): a point where the one-sided differences disagree says nothing and is passed over.
void expect_exact_gradients(SmoothProgram& program, int points, Rng& rng) {
  constexpr double kStep = 1e-6;
  SmoothProgram::Values at, ahead, behind;
  int compared = 0;
  for (int n = 0; n < points; ++n) {
    const Eigen::VectorXd v = random_point(program, rng);
    program.evaluate(v, at);
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      Eigen::VectorXd moved = v;
      moved[i] = v[i] + kStep;
      program.evaluate(moved, ahead);
      moved[i] = v[i] - kStep;
      program.evaluate(moved, behind);
      EXPECT_NEAR((ahead.objective - behind.objective) / (2 * kStep), at.gradient[i], 1e-7);
      for (Eigen::Index row = 0; row < at.rows.size(); ++row) {
        const double forward = (ahead.rows[row] - at.rows[row]) / kStep;
        const double backward = (at.rows[row] - behind.rows[row]) / kStep;
        if (std::abs(forward - backward) > 1e-3) continue;
        ++compared;
        EXPECT_NEAR(0.5 * (forward + backward), at.jacobian(row, i), 2e-5)
            << "row " << row << ", variable " << i << ", value " << at.rows[row];
      }
    }
  }
  EXPECT_GE(compared, points * static_cast<int>(program.n_variables()));  // at least one row's worth at every point
}

// Differences of the Lagrangian's gradient against its exact Hessian.
void expect_exact_hessian(SmoothProgram& program, int points, Rng& rng) {
  constexpr double kStep = 1e-6;
  SmoothProgram::Values values;
  for (int n = 0; n < points; ++n) {
    const Eigen::VectorXd v = random_point(program, rng);
    Eigen::VectorXd multipliers(program.n_rows());
    for (Eigen::Index i = 0; i < multipliers.size(); ++i) multipliers[i] = rng.uniform(-1.0, 1.0);
    const auto gradient = [&](const Eigen::VectorXd& point) -> Eigen::VectorXd {
      program.evaluate(point, values);
      return 0.7 * values.gradient + values.jacobian.transpose() * multipliers;
    };
    const Eigen::MatrixXd H = program.hessian(v, 0.7, multipliers);
    EXPECT_LE((H - H.transpose()).norm(), 1e-12);
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      Eigen::VectorXd moved = v;
      moved[i] = v[i] + kStep;
      Eigen::VectorXd difference = gradient(moved);
      moved[i] = v[i] - kStep;
      difference = (difference - gradient(moved)) / (2 * kStep);
      EXPECT_LE((difference - H.col(i)).cwiseAbs().maxCoeff(), 1e-5);
    }
  }
}

RobotProblemSpec spec_of(const char* id) { return load_problem_file(id).instance()->spec(); }

std::vector<int> types(const RobotProblemSpec& spec, std::initializer_list<const char*> names) {
  std::vector<int> result;
  for (const char* name : names) result.push_back(spec.library->find(name).value());
  return result;
}

Goal pose_goal(std::vector<Tolerance> tolerances) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d{0.8, 0.4, 1.1};
  X.linear() = Eigen::AngleAxisd{0.9, Eigen::Vector3d{1.0, 2.0, -1.0}.normalized()}.toRotationMatrix();
  return {"1", GoalType::kReach, PoseRegion{X, std::move(tolerances)}};
}

TEST(TaskProgram, HasExactDerivativesForBallGoals) {
  const RobotProblem problem{spec_of("seed/fixed")};
  TaskProgram program{problem, types(problem.spec(), {"hinge", "link", "rotary"}), {}};
  EXPECT_EQ(program.n_variables(), 2 + 1 + 2 + 3);  // lengths, then base, hinge and rotary
  ASSERT_EQ(program.balls().size(), 1u);
  Rng rng{1};
  expect_exact_gradients(program, 20, rng);
  expect_exact_hessian(program, 10, rng);
}

TEST(TaskProgram, HasExactDerivativesForEveryProjection) {
  RobotProblemSpec spec = spec_of("seed/fixed");
  for (const Projection projection :
       {Projection::kX, Projection::kY, Projection::kZ, Projection::kRCyl, Projection::kPhiCyl, Projection::kRSph,
        Projection::kTheta, Projection::kPhiSph, Projection::kNx, Projection::kNy, Projection::kNz,
        Projection::kThetaR}) {
    for (const double lower : {0.0, 0.02}) {  // from zero: a ball where there is one; else an interval
      SCOPED_TRACE(std::string{name(projection)});
      spec.task = std::make_shared<GoalTask>(
          "pose", std::vector<Goal>{pose_goal({{projection, lower, 0.1, Eigen::Matrix3d::Identity()}})});
      const RobotProblem problem{spec};
      TaskProgram program{problem, types(spec, {"rotary", "hinge"}), {}};
      Rng rng{2};
      expect_exact_gradients(program, 8, rng);
    }
  }
}

TEST(TaskProgram, HasAnExactHessianForPoseGoals) {
  RobotProblemSpec spec = spec_of("seed/fixed");
  spec.task = std::make_shared<GoalTask>(
      "two poses",
      std::vector<Goal>{pose_goal({{Projection::kRSph, 0.0, 0.01, Eigen::Matrix3d::Identity()},
                                   {Projection::kThetaR, 0.0, 0.1, Eigen::Matrix3d::Identity()}}),
                        pose_goal({{Projection::kX, -0.01, 0.01, Eigen::Matrix3d::Identity()},
                                   {Projection::kRCyl, 0.0, 0.01, Eigen::Matrix3d::Identity()}})});
  const RobotProblem problem{spec};
  TaskProgram program{problem, types(spec, {"hinge", "rotary"}), {}};
  EXPECT_EQ(program.n_variables(), 4 + 3 + 3);
  Rng rng{3};
  expect_exact_gradients(program, 10, rng);
  expect_exact_hessian(program, 5, rng);
}

TEST(TaskProgram, HasExactGradientsOfClearance) {
  RobotProblemSpec spec = spec_of("seed/random_obstacles");
  spec.level = Level::kPostureSelf;
  const RobotProblem problem{spec};
  TaskProgram program{problem, types(spec, {"hinge", "rotary", "hinge"}), {}};
  Rng rng{4};
  expect_exact_gradients(program, 25, rng);
}

TEST(TaskProgram, HasExactDerivativesInATwist) {
  // The seed library with a link that is turned about its axis by a parameter, and a box beside the axis.
  std::vector<ModuleType> modules;
  const std::shared_ptr<const ModuleLibrary> seed = load_library("seed");
  modules.push_back(seed->base());
  for (int k = 0; k < seed->n_types(); ++k) modules.push_back(seed->type(k));
  ModuleType& link = modules[1];
  link.parameters.push_back({"twist", "rad", -1.0, 1.0});
  ModuleBody far = link.bodies[0];
  far.id = "far";
  far.collision = {{AffineShape{AffineShape::Kind::kBox, {0.1, 0.4, 0.1}, nullptr},
                    AffinePose{Eigen::Isometry3d{Eigen::Translation3d{0.3, 0.0, 0.2}}}}};
  far.connectors.erase(far.connectors.begin());
  link.bodies[0].connectors.pop_back();
  link.bodies.push_back(far);
  ModuleJoint twist;
  twist.joint.name = "twist";
  twist.fixed = true;
  twist.angle = AffineScalar::of_parameter(1);
  twist.child = 1;
  link.joints = {twist};

  RobotProblemSpec spec = spec_of("seed/random_obstacles");
  spec.library = std::make_shared<const ModuleLibrary>("twisted", std::move(modules));
  spec.level = Level::kPostureSelf;
  spec.task = std::make_shared<GoalTask>(
      "pose", std::vector<Goal>{pose_goal({{Projection::kRSph, 0.0, 0.01, Eigen::Matrix3d::Identity()},
                                           {Projection::kThetaR, 0.0, 0.1, Eigen::Matrix3d::Identity()},
                                           {Projection::kNz, -0.1, 0.1, Eigen::Matrix3d::Identity()}})});
  const RobotProblem problem{spec};
  TaskProgram program{problem, types(spec, {"hinge", "link", "hinge"}), {}};
  EXPECT_EQ(program.n_variables(), 2 + 2 + 2 + 3);
  Rng rng{6};
  expect_exact_gradients(program, 15, rng);
  spec.level = Level::kNone;  // rows of clearance have no second derivatives
  const RobotProblem free{spec};
  TaskProgram poses{free, types(spec, {"hinge", "link", "hinge"}), {}};
  expect_exact_hessian(poses, 5, rng);
}

TEST(TaskProgram, StartsWithinItsBoundsAndAtPosturesThatComeClose) {
  const RobotProblem problem{spec_of("seed/random_obstacles")};
  TaskProgram program{problem, types(problem.spec(), {"hinge", "hinge"}), {}};
  SmoothProgram::Values values;
  for (int i = 0; i < 20; ++i) {
    const Eigen::VectorXd v = program.start(i);
    EXPECT_TRUE((v.array() >= program.lower().array()).all() && (v.array() <= program.upper().array()).all());
    program.evaluate(v, values);
    // The annulus of two hinges of 0.5 .. 1.5 m leaves at most the hole in its middle.
    EXPECT_LE(values.rows.head<3>().norm(), 1.5);
    EXPECT_EQ(program.start(i), v);
  }
}

TEST(TaskProgram, TakesRowsThatATaskAddsItself) {
  // The first joint of the first goal may not go beyond half a turn less one radian, as a row.
  class Bounded final : public Task {
   public:
    explicit Bounded(const Task& inner) : goals_{inner.goals().begin(), inner.goals().end()} {}
    [[nodiscard]] std::string_view name() const override { return "bounded"; }
    [[nodiscard]] std::span<const Goal> goals() const override { return goals_; }
    void add_rows(RowSink& sink, const Chain&) const override {
      const int variable = sink.joint(0, 0);
      sink.add(-kPi + 1.0, kPi - 1.0, [variable](const Eigen::VectorXd& v, Eigen::Ref<Eigen::RowVectorXd> gradient) {
        gradient[variable] = 1.0;
        return v[variable];
      });
    }

   private:
    std::vector<Goal> goals_;
  };
  RobotProblemSpec spec = spec_of("seed/random_obstacles");
  spec.task = std::make_shared<Bounded>(*spec.task);
  const RobotProblem problem{spec};
  TaskProgram program{problem, types(spec, {"hinge"}), {}};
  Rng rng{5};
  const Eigen::VectorXd v = random_point(program, rng);
  SmoothProgram::Values values;
  program.evaluate(v, values);
  EXPECT_EQ(values.rows[program.n_rows() - 1], v[2]);
  EXPECT_EQ(values.jacobian(program.n_rows() - 1, 2), 1.0);
  EXPECT_EQ(program.row_upper()[program.n_rows() - 1], kPi - 1.0);
}

TEST(TaskProgram, DesignsStayWithinTheLibrarysIntervals) {
  const RobotProblem problem{spec_of("seed/fixed")};
  TaskProgram program{problem, types(problem.spec(), {"hinge"}), {}};
  Eigen::VectorXd v = program.start(0);
  v.head<2>() << 0.5 - 1e-9, 1.5 + 1e-9;
  const Design design = program.design(v);
  EXPECT_EQ(design.modules[0].parameters[0], 0.5);
  EXPECT_EQ(design.modules[0].parameters[1], 1.5);
}

}  // namespace
}  // namespace modsearch
