#include <gtest/gtest.h>

#include <modsearch/kinematics/scene.hpp>

#include "problem/planar_arm.hpp"

namespace modsearch {
namespace {

using testing::arm_of;
using testing::at;
using testing::ball;
using testing::planar_arm;
using testing::point;

GoalTask reach(Eigen::VectorXd home = {}) { return GoalTask{"t", {point("1", 1.2, 2.0)}, std::move(home)}; }

Attempt planned(const Task& task, const Chain& chain, const Scene& scene) {
  return task.attempt(arm_of(chain), scene, {.level = Level::kPath, .ik = {}, .planner = {}});
}

TEST(Home, IsWhereAllJointsAreAtZeroIfThatIsFree) {
  const Chain chain = planar_arm();
  EXPECT_EQ(home_posture(reach(), arm_of(chain), {}), Eigen::Vector2d::Zero());
  const Scene beside{{ball("ball", 1.0, 0.2, 0.1)}};  // 0.05 m away from the stretched arm
  EXPECT_EQ(home_posture(reach(), arm_of(chain), beside), Eigen::Vector2d::Zero());
}

TEST(Home, IsClampedIntoTheLimits) {
  ChainBuilder builder{0};
  builder.joint({.name = "turn", .lower = 0.5, .upper = 1.0}).move(at(1, 0, 0));
  const Chain chain = builder.build();
  EXPECT_EQ(home_posture(reach(), arm_of(chain), {}), Eigen::VectorXd::Constant(1, 0.5));
  EXPECT_EQ(home_posture(reach(Eigen::VectorXd::Constant(1, 3.0)), arm_of(chain), {}),
            Eigen::VectorXd::Constant(1, 1.0));
}

TEST(Home, IsTheFirstFreePostureOfAFixedSetWhereZeroIsNot) {
  const Chain chain = planar_arm();
  const Scene scene{{ball("ball", 1.5, 0.0, 0.2)}};
  const Eigen::VectorXd home = home_posture(reach(), arm_of(chain), scene);
  EXPECT_EQ(home, home_posture(reach(), arm_of(chain), scene));
  EXPECT_FALSE(home.isZero());
  EXPECT_EQ(home, chain.clamped(home));
  Work work;
  EXPECT_FALSE(scene.collides(arm_of(chain), arm_of(chain).forward(home), work));
  const Attempt result = planned(reach(), chain, scene);
  ASSERT_TRUE(result.achieved) << name(result.why);
  EXPECT_EQ(result.path->waypoints.row(0).transpose(), home);
}

TEST(Home, KeepsClearOfItself) {
  // With all joints at 0 the third of three links of 1 m lies on the first: its joints are turned by half a turn.
  ChainBuilder builder{0};
  Eigen::Isometry3d along_x = at(0.5, 0, 0);
  along_x.linear() = Eigen::AngleAxisd{std::numbers::pi / 2, Eigen::Vector3d::UnitY()}.toRotationMatrix();
  const AffineShape capsule{AffineShape::Kind::kCapsule, {0.05, 0.6}, nullptr};
  Eigen::Isometry3d back = at(1, 0, 0);
  back.linear() = Eigen::AngleAxisd{std::numbers::pi, Eigen::Vector3d::UnitZ()}.toRotationMatrix();
  for (int i = 0; i < 3; ++i) {
    builder.joint({.name = "turn", .lower = -2.0, .upper = 2.0}, i - 1, i);
    builder.body("link", i, 1.0, {{capsule, along_x}}, {.X_FB = at(0.5, 0, 0), .r_com = {}});
    builder.move(back);
  }
  const Chain chain = builder.build();
  Work work;
  const Arm arm = arm_of(chain);
  ASSERT_TRUE(self_collides(arm, arm.forward(Eigen::Vector3d::Zero()), work));
  EXPECT_FALSE(self_collides(arm, arm.forward(home_posture(reach(), arm, {})), work));
}

TEST(Home, ThatATaskGivesStaysWhateverStandsThere) {
  const Chain chain = planar_arm();
  const Scene scene{{ball("ball", 1.5, 0.0, 0.2)}};
  const Eigen::VectorXd given = Eigen::VectorXd::Constant(1, 0.01);  // the second joint is filled up with 0
  EXPECT_EQ(home_posture(reach(given), arm_of(chain), scene), Eigen::Vector2d(0.01, 0.0));
  const Attempt result = planned(reach(given), chain, scene);
  EXPECT_TRUE(result.reached);
  EXPECT_EQ(result.why, Failure::kHomeInCollision);
}

TEST(Home, IsZeroAfterAllWhereNothingIsFree) {
  const Chain chain = planar_arm();
  const Scene scene{{{"everything", {{Box{{5.0, 5.0, 1.0}}, at(0, 0, 0)}}}}};
  EXPECT_EQ(home_posture(reach(), arm_of(chain), scene), Eigen::Vector2d::Zero());
}

TEST(Home, KeepsClearOfWhatMovesWhereItBegins) {
  const Chain chain = planar_arm();
  Obstacle moving = ball("moving", 0.0, 0.0, 0.2);
  moving.motion = {{1.0, 2.0}, {at(1.5, 0, 0), at(1.5, 0, 3)}};
  const Scene scene{{moving}};
  const Eigen::VectorXd home = home_posture(reach(), arm_of(chain), scene);
  EXPECT_FALSE(home.isZero());
  const Eigen::Vector3d centre{1.5, 0.0, 0.0};
  EXPECT_GT((arm_of(chain).forward(home).tip.translation() - centre).norm(), 0.2);
}

}  // namespace
}  // namespace modsearch
