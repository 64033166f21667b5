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

// Central differences of rows and objective against the exact first derivatives at random points. Rows of clearance
// have kinks (two faces equally close): a point where the one-sided differences disagree says nothing and is passed
// over.
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
  for (const Projection projection : {Projection::kX, Projection::kY, Projection::kZ, Projection::kRCyl,
                                      Projection::kPhiCyl, Projection::kRSph, Projection::kTheta, Projection::kPhiSph,
                                      Projection::kNx, Projection::kNy, Projection::kNz, Projection::kThetaR}) {
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
      "two poses", std::vector<Goal>{pose_goal({{Projection::kRSph, 0.0, 0.01, Eigen::Matrix3d::Identity()},
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

TEST(TaskProgram, HasAnExactHessianForEveryProjection) {
  RobotProblemSpec spec = spec_of("seed/fixed");
  Rng rng{7};
  for (const Projection projection : {Projection::kX, Projection::kY, Projection::kZ, Projection::kRCyl,
                                      Projection::kPhiCyl, Projection::kRSph, Projection::kTheta, Projection::kPhiSph,
                                      Projection::kNx, Projection::kNy, Projection::kNz, Projection::kThetaR}) {
    for (const double lower : {0.0, 0.02}) {
      SCOPED_TRACE(std::string{name(projection)});
      const Eigen::Matrix3d R_TN = Eigen::AngleAxisd{0.4, Eigen::Vector3d{2.0, -1.0, 1.0}.normalized()}.matrix();
      spec.task = std::make_shared<GoalTask>("pose", std::vector<Goal>{pose_goal({{projection, lower, 0.1, R_TN}})});
      const RobotProblem problem{spec};
      TaskProgram program{problem, types(spec, {"rotary", "hinge"}), {}};
      expect_exact_hessian(program, 4, rng);
    }
  }
}

// Close to the nominal orientation the curvature comes from a series.
TEST(TaskProgram, HasAnExactHessianCloseToTheNominalOrientation) {
  RobotProblemSpec spec = spec_of("seed/fixed");
  const RobotProblem any{spec};
  const std::vector<int> sequence = types(spec, {"rotary", "hinge"});
  Rng rng{8};
  for (const double angle : {0.0, 1e-3, 0.09, 0.11}) {
    TaskProgram draws{any, sequence, {}};
    const Eigen::VectorXd v = random_point(draws, rng);
    const std::shared_ptr<const Chain> chain = any.chain(sequence);
    const Arm arm = chain->at(v.head(4));
    Eigen::Isometry3d X_WN = arm.forward(v.tail(3)).tip;
    X_WN.linear() =
        X_WN.linear() * Eigen::AngleAxisd{angle, Eigen::Vector3d{1.0, 2.0, -2.0}.normalized()}.toRotationMatrix();
    spec.task = std::make_shared<GoalTask>(
        "pose", std::vector<Goal>{{"1", GoalType::kReach,
                                   PoseRegion{X_WN, {{Projection::kThetaR, 0.0, 0.1, Eigen::Matrix3d::Identity()}}}}});
    const RobotProblem problem{spec};
    TaskProgram program{problem, sequence, {}};
    const Eigen::Vector3d multipliers{0.3, -0.8, 0.5};
    const Eigen::MatrixXd H = program.hessian(v, 1.0, multipliers);
    SmoothProgram::Values ahead, behind;
    constexpr double kStep = 1e-6;
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      program.evaluate(v + kStep * Eigen::VectorXd::Unit(v.size(), i), ahead);
      program.evaluate(v - kStep * Eigen::VectorXd::Unit(v.size(), i), behind);
      const Eigen::VectorXd column = (ahead.jacobian - behind.jacobian).transpose() * multipliers / (2.0 * kStep);
      EXPECT_LE((column - H.col(i)).cwiseAbs().maxCoeff(), 1e-8);  // rounding: 1e-16 / 1e-6
    }
  }
}

// Of the rows of clearance that the whole program has, those are there that are below the two margins; each row holds
// what the whole program's does.
TEST(TaskProgram, LeavesOutRowsOfPairsThatAreFarApart) {
  RobotProblemSpec spec = spec_of("seed/random_obstacles");
  spec.level = Level::kPostureSelf;
  const RobotProblem problem{spec};
  const std::vector<int> sequence = types(problem.spec(), {"hinge", "rotary", "hinge"});
  const Relaxation relaxation{.clearance_margin = 0.01, .near = 0.05};
  Relaxation whole = relaxation;
  whole.all_rows = true;
  TaskProgram all{problem, sequence, whole};
  TaskProgram some{problem, sequence, relaxation};
  EXPECT_EQ(some.n_rows(), 3);
  EXPECT_GT(all.n_rows(), 3);
  Rng rng{9};
  SmoothProgram::Values values_all, values_some;
  int left_out = 0, looked_at = 0;
  for (int n = 0; n < 50; ++n) {
    const Eigen::VectorXd v = random_point(all, rng);
    all.evaluate(v, values_all);
    std::vector<double> near;
    for (Eigen::Index row = 3; row < all.n_rows(); ++row) {
      EXPECT_EQ(all.row_lower()[row], 0.01);
      if (values_all.rows[row] < 0.01 + 0.05) near.push_back(values_all.rows[row]);
    }
    some.shrink();
    EXPECT_EQ(some.n_rows(), 3);
    EXPECT_EQ(some.grow(v), static_cast<int>(near.size()));
    EXPECT_EQ(some.grow(v), 0);
    some.evaluate(v, values_some);
    ASSERT_EQ(values_some.rows.size(), 3 + static_cast<Eigen::Index>(near.size()));
    std::vector<double> rows(values_some.rows.begin() + 3, values_some.rows.end());
    std::sort(rows.begin(), rows.end());
    std::sort(near.begin(), near.end());
    EXPECT_EQ(rows, near);
    EXPECT_EQ(some.violation(v, values_some.rows), all.violation(v, values_all.rows));
    looked_at += all.n_rows() - 3;
    left_out += all.n_rows() - some.n_rows();
  }
  EXPECT_GT(left_out, looked_at / 2);
}

TEST(TaskProgram, HasNothingToLeaveOutWhereBodiesAreNotCompared) {
  RobotProblemSpec spec = spec_of("seed/random_obstacles");
  spec.level = Level::kNone;
  const RobotProblem problem{spec};
  TaskProgram program{problem, types(problem.spec(), {"hinge", "hinge"}), {}};
  Rng rng{10};
  EXPECT_EQ(program.grow(random_point(program, rng)), 0);
  EXPECT_EQ(program.n_rows(), 3);
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
  TaskProgram program{problem, types(spec, {"hinge", "link", "hinge"}), {.all_rows = true}};
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

// A straight line of 21 poses: 8 of them are the task's goals, and 21 are as many as there are.
TEST(TaskProgram, TakesMorePosesOfATrajectoryThanTheTaskHasGoals) {
  RobotProblemSpec spec = spec_of("seed/fixed");
  Trajectory line;
  for (int k = 0; k <= 20; ++k) line.poses.push_back(PoseRegion::ball({1.0, 0.02 * k, 1.0}, 0.001));
  const FollowStep step = follow("line", line, 0);
  spec.task = std::make_shared<GoalTask>(GoalTaskSpec{.name = "line", .goals = step.goals, .steps = {step.step}});
  const RobotProblem problem{spec};
  const std::vector<int> sequence = types(spec, {"rotary", "hinge"});
  TaskProgram coarse{problem, sequence, {}};
  EXPECT_EQ(coarse.n_variables(), 4 + 8 * 3);
  EXPECT_EQ(coarse.n_rows(), 8 * 3 + 7 * 3);  // positions, and joints on the ways between
  TaskProgram fine{problem, sequence, {.knots = 100}};
  EXPECT_EQ(fine.n_variables(), 4 + 21 * 3);
  ASSERT_EQ(fine.n_rows(), 21 * 3 + 20 * 3);
  EXPECT_EQ(fine.row_upper()[fine.n_rows() - 1], FollowOptions{}.largest_step);  // from one pose to the next
  Rng rng{12};
  expect_exact_gradients(fine, 2, rng);
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
