#include <gtest/gtest.h>

#include <modsearch/kinematics/interruption.hpp>
#include <modsearch/kinematics/path_planning.hpp>
#include <numbers>

namespace modsearch {
namespace {

TEST(Interruption, IsOnlyWhereSomeScopeAsksForIt) {
  EXPECT_NO_THROW(interruption_point());
  bool stop = false;
  const Interruptible outer{[&] { return stop; }};
  EXPECT_NO_THROW(interruption_point());
  {
    const Interruptible inner{[] { return false; }};
    stop = true;
    EXPECT_THROW(interruption_point(), Interrupted) << "the outer scope can stop what is within the inner one";
  }
  stop = false;
  EXPECT_NO_THROW(interruption_point());
}

TEST(Interruption, EndsWithItsScope) {
  {
    const Interruptible scope{[] { return true; }};
  }
  EXPECT_NO_THROW(interruption_point());
}

// A link of 1 m that turns about z and has to get past a wall on either side of it: the straight line is blocked and so
// is every other way, so that the planner would use up its iterations.
TEST(Interruption, EndsAPlanInItsMiddle) {
  ChainBuilder builder{0};
  builder.joint({.name = "turn", .lower = -3.0, .upper = 3.0});
  Eigen::Isometry3d along_x{Eigen::Translation3d{0.5, 0.0, 0.0}};
  along_x.linear() = Eigen::AngleAxisd{std::numbers::pi / 2, Eigen::Vector3d::UnitY()}.toRotationMatrix();
  builder.body("link", 0, 1.0, {{{AffineShape::Kind::kCapsule, {0.05, 0.8}, nullptr}, along_x}});
  builder.move(Eigen::Isometry3d{Eigen::Translation3d{1.0, 0.0, 0.0}});
  const Chain chain = builder.build();
  const Arm arm = chain.at(Eigen::VectorXd{0});
  const Scene scene{{{"wall", {{Sphere{0.2}, Eigen::Isometry3d{Eigen::Translation3d{0.8, 0.0, 0.0}}}}}}};
  const Eigen::VectorXd from = Eigen::VectorXd::Constant(1, -1.5);
  const Eigen::VectorXd to = Eigen::VectorXd::Constant(1, 1.5);
  int asked = 0;
  const Plan whole = plan_path(arm, scene, from, to);
  EXPECT_EQ(whole.status, PlanStatus::kNotFound);
  {
    const Interruptible scope{[&] { return ++asked > 200; }};
    EXPECT_THROW(static_cast<void>(plan_path(arm, scene, from, to)), Interrupted);
  }
  const Interruptible patient{[] { return false; }};
  const Plan again = plan_path(arm, scene, from, to);
  EXPECT_EQ(again.status, whole.status);
  EXPECT_EQ(again.work.planner_states, whole.work.planner_states) << "a scope that does not stop changes nothing";
}

}  // namespace
}  // namespace modsearch
