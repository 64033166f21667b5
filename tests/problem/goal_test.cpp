#include <gtest/gtest.h>

#include <modsearch/problem/goal.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

Eigen::Isometry3d pose(double x, double angle) {
  Eigen::Isometry3d X{Eigen::Translation3d{x, 0.0, 1.0}};
  X.rotate(Eigen::AngleAxisd{angle, Eigen::Vector3d::UnitZ()});
  return X;
}

TEST(Resampled, PutsPosesOnTheStraightLineBetween) {
  const Trajectory given{{PoseRegion::ball({0.0, 0.0, 1.0}, 1e-3), PoseRegion::ball({0.1, 0.0, 1.0}, 2e-3)},
                         {1.0, 2.0}};
  const Trajectory dense = resampled(given, 0.02);
  ASSERT_EQ(dense.poses.size(), 6U);
  ASSERT_EQ(dense.times.size(), 6U);
  for (int i = 0; i < 6; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_NEAR(dense.poses[k].nominal().translation().x(), 0.02 * i, 1e-12);
    EXPECT_NEAR(dense.times[k], 1.0 + 0.2 * i, 1e-12);
    EXPECT_EQ(dense.poses[k].tolerances()[0].upper, i == 0 ? 1e-3 : 2e-3);
  }
  // Dense already: nothing is added.
  EXPECT_EQ(resampled(dense, 0.02).poses.size(), 6U);
}

TEST(Resampled, TurnsAboutOneAxisAndTakesFramesAlong) {
  const Tolerance turning{.projection = Projection::kThetaR, .lower = 0.0, .upper = 0.01};
  const auto region = [&](double x, double angle) {
    const Eigen::Isometry3d X = pose(x, angle);
    // The second tolerance is along the world's x, whatever the pose.
    return PoseRegion{X, {turning, {.projection = Projection::kX, .lower = -0.01, .upper = 0.01, .R_TN = X.linear()}}};
  };
  const Trajectory dense = resampled({{region(0.0, 0.3), region(0.0, 1.3)}, {}}, 0.02, 0.25);
  ASSERT_EQ(dense.poses.size(), 5U);
  const PoseRegion& middle = dense.poses[2];
  EXPECT_TRUE(middle.nominal().isApprox(pose(0.0, 0.8), 1e-12));
  Eigen::Isometry3d X = middle.nominal();
  X.translation().x() += 0.009;
  EXPECT_TRUE(middle.contains(X));
  X.translation().x() += 0.002;
  EXPECT_FALSE(middle.contains(X));
  X = middle.nominal();
  X.translation().y() += 5.0;  // not along the world's x
  EXPECT_TRUE(middle.contains(X));
}

TEST(Follow, MakesGoalsOfEvenlySpreadPoses) {
  const Trajectory given{{PoseRegion::ball({0.0, 0.0, 1.0}, 1e-3), PoseRegion::ball({1.0, 0.0, 1.0}, 1e-3)}, {}};
  const FollowStep seam = follow("seam", given, 3, {}, 6);
  EXPECT_EQ(seam.step.goal, 3);
  EXPECT_EQ(seam.step.trajectory->poses.size(), 51U);
  EXPECT_EQ(seam.step.knots, (std::vector<int>{0, 10, 20, 30, 40, 50}));
  ASSERT_EQ(seam.goals.size(), 6U);
  EXPECT_NEAR(seam.goals[1].position().x(), 0.2, 1e-12);
  EXPECT_EQ(seam.goals[0].type, GoalType::kFollow);
}

TEST(Follow, RefusesWhatIsNoTrajectory) {
  const PoseRegion here = PoseRegion::ball({0.0, 0.0, 1.0}, 1e-3);
  EXPECT_THROW((void)follow("f", {{here}, {}}, 0), std::invalid_argument);
  EXPECT_THROW((void)follow("f", {{here, here}, {0.0}}, 0), std::invalid_argument);
  EXPECT_THROW((void)follow("f", {{here, here}, {1.0, 1.0}}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
