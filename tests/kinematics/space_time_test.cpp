#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/kinematics/pose_following.hpp>
#include <modsearch/kinematics/space_time.hpp>

#include "kinematics/sample_arms.hpp"

namespace modsearch {
namespace {

using sample::translation;

// One link of 1 m, a capsule of radius 0.05, that turns about the world's z at 1 rad/s.
Chain pointer() {
  ChainBuilder builder{0};
  builder.joint({.name = "turn", .lower = -3.0, .upper = 3.0, .velocity = 1.0});
  const AffineShape capsule{AffineShape::Kind::kCapsule, {0.05, 1.0}, nullptr};
  Eigen::Isometry3d along_x = translation(0.5, 0, 0);
  along_x.linear() = Eigen::AngleAxisd{sample::kPi / 2, Eigen::Vector3d::UnitY()}.toRotationMatrix();
  builder.body("link", 0, 1.0, {{capsule, along_x}});
  builder.move(translation(1, 0, 0));
  return builder.build();
}

// A ball of radius 0.1 that stands at (1, 0, 0) + `from` until time `t`, and has moved by `to` a second later.
Scene ball(const Eigen::Vector3d& from, double t, const Eigen::Vector3d& to) {
  Obstacle obstacle{"ball", {{Sphere{0.1}, translation(1.0, 0.0, 0.0)}}};
  obstacle.motion = {{t, t + 1.0}, {translation(from.x(), from.y(), from.z()), translation(to.x(), to.y(), to.z())}};
  return Scene{{obstacle}};
}

Eigen::VectorXd angle(double q) { return Eigen::VectorXd::Constant(1, q); }

TEST(Keyframes, MoveOnStraightLinesAndTurnAtConstantSpeed) {
  Eigen::Isometry3d turned = translation(1.0, 0.0, 0.0);
  turned.rotate(Eigen::AngleAxisd{1.0, Eigen::Vector3d::UnitZ()});
  const Keyframes motion{{1.0, 3.0}, {translation(0, 0, 0), turned}};
  EXPECT_TRUE(motion.at(0.0).isApprox(translation(0, 0, 0)));
  EXPECT_TRUE(motion.at(9.0).isApprox(turned));
  Eigen::Isometry3d half = translation(0.5, 0.0, 0.0);
  half.rotate(Eigen::AngleAxisd{0.5, Eigen::Vector3d::UnitZ()});
  EXPECT_TRUE(motion.at(2.0).isApprox(half, 1e-12));
  EXPECT_NEAR(motion.fastest(2.0, 0.0, 9.0), (1.0 + 2.0 * 1.0) / 2.0, 1e-12);
  EXPECT_EQ(motion.fastest(2.0, 4.0, 9.0), 0.0);
}

TEST(Keyframes, AreRefusedWhenTheirTimesDoNotRise) {
  Obstacle obstacle{"ball", {{Sphere{0.1}, translation(1, 0, 0)}}};
  obstacle.motion = {{1.0, 1.0}, {translation(0, 0, 0), translation(0, 0, 0)}};
  EXPECT_THROW((Scene{{obstacle}}), std::invalid_argument);
  obstacle.motion = {{1.0}, {}};
  EXPECT_THROW((Scene{{obstacle}}), std::invalid_argument);
}

TEST(Scene, LeavesMovingObstaclesToThoseWhoKnowTheTime) {
  const Chain chain = pointer();
  const Arm arm = chain.at(Eigen::VectorXd{0});
  const Scene scene = ball({0, 0, 0}, 1.0, {0, 0, 2});
  Work work;
  const Posture posture = arm.forward(angle(0.0));
  EXPECT_TRUE(std::isinf(scene.clearance(arm, posture, work)));
  EXPECT_TRUE(scene.any_moves());
  EXPECT_FALSE(scene.any_rests());
  // The ball's centre is on the capsule's end until 1 s; half way up, 1 m away, at 1.5 s.
  EXPECT_LT(clearance_at(arm, posture, scene, 0.5, work), 0.0);
  EXPECT_NEAR(clearance_at(arm, posture, scene, 1.5, work), 1.0 - 0.15, 1e-9);
}

// The ball blocks the way from -1 to 1 rad until it rises after 5 s.
TEST(PlanInTime, WaitsUntilTheObstacleHasGone) {
  const Chain chain = pointer();
  const Arm arm = chain.at(Eigen::VectorXd{0});
  const Scene scene = ball({0, 0, 0}, 5.0, {0, 0, 2});
  const Plan plan = plan_in_time(arm, scene, angle(-1.0), 0.0, angle(1.0), 0.0);
  ASSERT_EQ(plan.status, PlanStatus::kExact);
  EXPECT_EQ(plan.path.waypoints(0, 0), -1.0);
  EXPECT_EQ(plan.path.waypoints(plan.path.waypoints.rows() - 1, 0), 1.0);
  // It meets the ball after 0.85 s at full speed: it starts 4.15 s late at least, and by 6.1 s the ball is out of
  // reach.
  EXPECT_GT(plan.path.times.back(), 5.0 + 1.0);
  EXPECT_LT(plan.path.times.back(), 5.2 + 2.0);
  EXPECT_TRUE(check_in_time(arm, scene, plan.path, 1e-3).free);
  for (std::size_t i = 1; i < plan.path.times.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double way = std::abs(plan.path.waypoints(row, 0) - plan.path.waypoints(row - 1, 0));
    EXPECT_LE(way, plan.path.times[i] - plan.path.times[i - 1] + 1e-9);
  }
  const Plan again = plan_in_time(arm, scene, angle(-1.0), 0.0, angle(1.0), 0.0);
  EXPECT_EQ(again.path.waypoints, plan.path.waypoints);
  EXPECT_EQ(again.path.times, plan.path.times);
}

// The ball comes down onto the start after 2 s and stays: waiting there is no way out, leaving at once is.
TEST(PlanInTime, LeavesBeforeTheObstacleComes) {
  const Chain chain = pointer();
  const Arm arm = chain.at(Eigen::VectorXd{0});
  const Scene scene = ball({0, 0, 2}, 1.0, {0, 0, 0});
  const Plan plan = plan_in_time(arm, scene, angle(0.0), 0.0, angle(1.0), 10.0);
  ASSERT_EQ(plan.status, PlanStatus::kExact);
  EXPECT_NEAR(plan.path.times.back(), 1.0, 1e-9);
  EXPECT_TRUE(check_in_time(arm, scene, plan.path, 1e-3).free);
  // To stay at the goal where it comes down is impossible.
  const Plan under = plan_in_time(arm, scene, angle(1.0), 0.0, angle(0.0), 10.0, {.plan = {.max_iterations = 200}});
  EXPECT_EQ(under.status, PlanStatus::kNotFound);
}

// The ball sweeps over the start before the goal is free: the arm has to step aside first, which only the tree finds.
TEST(PlanInTime, StepsAside) {
  const Chain chain = pointer();
  const Arm arm = chain.at(Eigen::VectorXd{0});
  Obstacle ball{"ball", {{Sphere{0.1}, translation(1.0, 0.0, 0.0)}}};
  const auto turn = [](double angle) { return Eigen::Isometry3d{Eigen::AngleAxisd{angle, Eigen::Vector3d::UnitZ()}}; };
  // From 1 rad, the goal, over 0, the start, to -1 rad, and out upwards.
  ball.motion = {{0.0, 3.0, 6.0, 7.0}, {turn(1.0), turn(0.0), turn(-1.0), translation(0, 0, 3) * turn(-1.0)}};
  const Scene scene{{ball}};
  const Plan plan = plan_in_time(arm, scene, angle(0.0), 0.0, angle(1.0), 0.0, {.horizon = 15.0});
  ASSERT_EQ(plan.status, PlanStatus::kExact);
  EXPECT_GT(plan.iterations, 0);
  EXPECT_TRUE(check_in_time(arm, scene, plan.path, 1e-3).free);
}

TEST(CheckInTime, FindsAnOverlapThatLastsAMoment) {
  const Chain chain = pointer();
  const Arm arm = chain.at(Eigen::VectorXd{0});
  // The ball falls through the tip's place between 1 s and 2 s.
  const Scene scene = ball({0, 0, 1}, 1.0, {0, 0, -1});
  Path path{Eigen::MatrixXd::Zero(2, 1), {0.0, 3.0}};
  EXPECT_FALSE(check_in_time(arm, scene, path, 0.01).free);
  path.times = {0.0, 1.4};  // at 1.4 s it is 0.2 m above
  const SpaceTimeCheck check = check_in_time(arm, scene, path, 0.01);
  EXPECT_TRUE(check.free);
  EXPECT_NEAR(check.clearance, 0.2 - 0.15, 1e-9);
  path.times = {0.0};
  EXPECT_THROW((void)check_in_time(arm, scene, path, 0.01), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
