#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/kinematics/pose_following.hpp>

#include "kinematics/sample_arms.hpp"

namespace modsearch {
namespace {

// Two links of 1 m in the plane, both joints about the world's z; `limit` of both, `velocity` of the second.
Chain planar(double limit = 3.0, double velocity = 1e9) {
  ChainBuilder builder{0};
  builder.joint({.name = "a", .lower = -limit, .upper = limit, .velocity = velocity});
  builder.move(sample::translation(1, 0, 0));
  builder.joint({.name = "b", .lower = -limit, .upper = limit, .velocity = velocity});
  builder.move(sample::translation(1, 0, 0));
  return builder.build();
}

std::vector<PoseRegion> line(const Eigen::Vector3d& from, const Eigen::Vector3d& to, int n) {
  std::vector<PoseRegion> poses;
  for (int i = 0; i < n; ++i) poses.push_back(PoseRegion::ball(from + (to - from) * i / (n - 1), 1e-6));
  return poses;
}

// The elbow's angle of a two-link arm by the law of cosines.
double elbow(const Eigen::Vector3d& p) { return std::acos((p.squaredNorm() - 2.0) / 2.0); }

TEST(FollowPoses, StaysOnTheBranchItBeginsOn) {
  const Chain chain = planar();
  const Arm arm = chain.at(Eigen::VectorXd{0});
  const std::vector<PoseRegion> poses = line({1.2, -0.8, 0.0}, {1.2, 0.8, 0.0}, 81);
  for (const double side : {1.0, -1.0}) {
    const Eigen::Vector3d p = poses.front().nominal().translation();
    const double b = side * elbow(p);
    const Eigen::Vector2d q{std::atan2(p.y(), p.x()) - 0.5 * b, b};  // equal links: the first lies half the elbow aside
    const Following way = follow_poses(arm, poses, {}, q);
    ASSERT_EQ(way.end, FollowEnd::kDone);
    EXPECT_EQ(way.n_followed, poses.size());
    for (std::size_t k = 0; k < poses.size(); ++k) {
      const Eigen::VectorXd q_k = way.postures.row(static_cast<Eigen::Index>(k)).transpose();
      EXPECT_TRUE(poses[k].contains(arm.forward(q_k).tip));
      EXPECT_NEAR(q_k[1], side * elbow(poses[k].nominal().translation()), 1e-5);
    }
    EXPECT_LT((way.postures.bottomRows(80) - way.postures.topRows(80)).cwiseAbs().maxCoeff(), 0.1);
  }
}

TEST(FollowPoses, EndsWhereTheArmIsTooShortAndSaysHowFarItGot) {
  const Chain chain = planar();
  const Arm arm = chain.at(Eigen::VectorXd{0});
  // The 11 points lie 0.1 m apart from 1.45 m on; those up to 1.95 m are within reach, and 2.05 m is 0.05 m too far.
  const std::vector<PoseRegion> poses = line({1.45, 0.0, 0.0}, {2.45, 0.0, 0.0}, 11);
  const double b = elbow(poses.front().nominal().translation());
  const Following way = follow_poses(arm, poses, {}, Eigen::Vector2d{-0.5 * b, b}, {.largest_step = 2.0});
  EXPECT_EQ(way.end, FollowEnd::kUnreachable);
  EXPECT_EQ(way.n_followed, 6U);
  EXPECT_NEAR(way.position_error, 0.05, 1e-6);
}

TEST(FollowPoses, CallsALargeStepAJump) {
  const Chain chain = planar();
  const Arm arm = chain.at(Eigen::VectorXd{0});
  const std::vector<PoseRegion> poses = line({0.0, -1.5, 0.0}, {0.0, 1.5, 0.0}, 2);
  const double b = elbow(poses.front().nominal().translation());
  const Following way = follow_poses(arm, poses, {}, Eigen::Vector2d{-sample::kPi / 2 - 0.5 * b, b});
  EXPECT_EQ(way.end, FollowEnd::kJump);
  EXPECT_EQ(way.n_followed, 1U);
}

// On a circle about the base only the first joint turns: 0.01 rad per pose.
TEST(FollowPoses, HoldsATimedTrajectoryAgainstTheVelocityLimit) {
  std::vector<PoseRegion> poses;
  std::vector<double> times;
  for (int i = 0; i <= 50; ++i) {
    poses.push_back(PoseRegion::ball({1.5 * std::cos(0.01 * i), 1.5 * std::sin(0.01 * i), 0.0}, 1e-9));
    times.push_back(0.02 * i);  // 0.5 rad/s
  }
  const double b = elbow({1.5, 0.0, 0.0});
  for (const auto& [velocity, end] : {std::pair{0.501, FollowEnd::kDone}, std::pair{0.499, FollowEnd::kTooFast}}) {
    const Chain chain = planar(3.0, velocity);
    const Arm arm = chain.at(Eigen::VectorXd{0});
    EXPECT_EQ(follow_poses(arm, poses, times, Eigen::Vector2d{-0.5 * b, b}).end, end) << velocity;
  }
}

TEST(NearbyPosture, LeavesAPostureThatIsThereAlone) {
  const Chain chain = planar();
  const Arm arm = chain.at(Eigen::VectorXd{0});
  const Eigen::Vector2d q{0.3, 1.0};
  const PoseRegion region = PoseRegion::ball(arm.forward(q).tip.translation(), 1e-3);
  const IkSolution same = nearby_posture(arm, region, q);
  EXPECT_TRUE(same.reached);
  EXPECT_EQ(same.postures.front(), q);
  EXPECT_THROW((void)nearby_posture(arm, region, Eigen::VectorXd::Zero(3)), std::invalid_argument);
}

TEST(TravelTime, IsThatOfTheSlowestJoint) {
  const Chain limited = planar(3.0, 0.5);
  EXPECT_DOUBLE_EQ(travel_time(limited, Eigen::Vector2d{0.0, 0.0}, Eigen::Vector2d{0.1, -0.2}), 0.4);
  const Chain free = planar(3.0, std::numeric_limits<double>::infinity());
  EXPECT_DOUBLE_EQ(travel_time(free, Eigen::Vector2d{0.0, 0.0}, Eigen::Vector2d{0.1, -0.2}), 0.2);
}

}  // namespace
}  // namespace modsearch
