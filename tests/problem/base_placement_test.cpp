#include <gtest/gtest.h>

#include <modsearch/problem/base_placement.hpp>
#include <modsearch/problem/files.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

BasePlacement somewhere() {
  BasePlacement placement;
  placement.X_WN = Eigen::Isometry3d{Eigen::Translation3d{0.5, -0.2, 0.1}};
  placement.X_WN.rotate(Eigen::AngleAxisd{0.4, Eigen::Vector3d::UnitY()});
  placement.R_TN = placement.X_WN.linear();  // along the world's axes
  placement.x = {-0.5, 0.5};
  placement.y = {-0.25, 0.5};
  placement.z = {0.1, 0.1};
  placement.yaw = {-1.0, 1.0};
  return placement;
}

// An arm on a placed base is the arm whose base was put there from the start.
TEST(BasePlacement, MovesTheArmAsABaseThatStandsThere) {
  const auto library = load_library("seed");
  const ModuleLibrary placed = with_placed_base(*library, somewhere());
  ASSERT_EQ(placed.n_types(), library->n_types() + 1);
  EXPECT_EQ(placed.type(0).id, library->base().id);
  ASSERT_EQ(placed.type(0).n_parameters(), 3);  // z has no width
  EXPECT_EQ(placed.successors({}), std::vector<int>{0});

  Rng rng{5};
  const int hinge = library->find("hinge").value();
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d place{rng.uniform(-0.5, 0.5), rng.uniform(-0.25, 0.5), rng.uniform(-1.0, 1.0)};
    Eigen::VectorXd lengths(4);
    for (double& length : lengths) length = rng.uniform(0.5, 1.5);
    Eigen::VectorXd x(7);
    x << place, lengths;

    // World axes: the offset is added in the world, the turn is about the base's own z axis.
    Eigen::Isometry3d X_WB = somewhere().X_WN;
    X_WB.translation() += Eigen::Vector3d{place.x(), place.y(), 0.1};
    X_WB.rotate(Eigen::AngleAxisd{place.z(), Eigen::Vector3d::UnitZ()});
    const Chain expected_chain = library->assemble(std::vector{hinge, hinge}, X_WB);
    const Chain chain = placed.assemble(std::vector{0, hinge + 1, hinge + 1}, somewhere().X_WN);
    ASSERT_EQ(chain.n_joints(), expected_chain.n_joints());
    const Arm expected = expected_chain.at(lengths);
    const Arm arm = chain.at(x);
    EXPECT_NEAR(arm.mass(), expected.mass(), 1e-12);
    Eigen::VectorXd q(chain.n_joints());
    for (double& angle : q) angle = rng.uniform(-3.0, 3.0);
    EXPECT_TRUE(arm.forward(q).tip.isApprox(expected.forward(q).tip, 1e-12));
    ASSERT_EQ(arm.geometries().size(), expected.geometries().size());
    EXPECT_TRUE((somewhere().X_WN * placement_of(placed.type(0), place)).isApprox(X_WB, 1e-12));
  }
}

TEST(BasePlacement, RefusesAnIntervalThatIsNone) {
  BasePlacement placement;
  placement.x = {0.5, -0.5};
  EXPECT_THROW((void)with_placed_base(*load_library("seed"), placement), std::invalid_argument);
}

// seed/fixed with a base that may come closer: the arm needs less length, so the best score is higher, and the base
// counts once.
TEST(BasePlacement, CountsTheBaseOnceAndLetsTheArmBeShorter) {
  const auto fixed = load_problem("seed/fixed");
  RobotProblemSpec spec = fixed->spec();
  BasePlacement placement;
  placement.x = {0.0, 0.5};
  spec.library = std::make_shared<const ModuleLibrary>(with_placed_base(*spec.library, placement));
  spec.placed_base = true;
  const RobotProblem problem{spec};
  EXPECT_EQ(problem.max_modules(), fixed->max_modules() + 1);
  const int hinge = problem.library().find("hinge").value();
  // From (0.25, 0, 0): proximal 0.5, distal hypot(0.75, 0.5) - 1 mm.
  const double distal = std::hypot(0.75, 0.5) - 0.0005;
  const Design design{{{0, Parameters::Constant(1, 0.25)}, {hinge, Parameters{{0.5, distal}}}}};
  const Evaluation evaluation = problem.evaluate(design);
  EXPECT_TRUE(evaluation.attempt.achieved);
  EXPECT_NEAR(evaluation.score, 350.0 - 5.0 * (0.5 + distal), 1e-9);
  EXPECT_EQ(problem.n_modules(design), 2);
  EXPECT_EQ(problem.base_pose(design).translation(), (Eigen::Vector3d{0.25, 0.0, 0.0}));
  EXPECT_EQ(problem.n_modules({}), 1);
  EXPECT_TRUE(std::isfinite(problem.evaluate({}).score));
}

}  // namespace
}  // namespace modsearch
