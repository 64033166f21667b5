#include <gtest/gtest.h>

#include "problem/planar_arm.hpp"

namespace modsearch {
namespace {

using testing::arm_of;
using testing::ball;
using testing::planar_arm;
using testing::point;
using testing::reaching;

// A planar arm of two links within a ring of balls of inner radius 1.7 m, in which it cannot stretch out to 2 m: the
// elbow stays on the side where it is at home.
class ElbowInARing : public ::testing::Test {
 protected:
  ElbowInARing() {
    constexpr int kBalls = 48;  // 0.24 m from one to the next, and 0.3 m across
    for (int i = 0; i < kBalls; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kBalls;
      obstacles.push_back(ball("ring", 1.85 * std::cos(angle), 1.85 * std::sin(angle), 0.15));
    }
  }

  [[nodiscard]] Attempt planned(const Eigen::MatrixXd& witness = {}) const {
    const GoalTask task{"t", {point("ahead", 1.2, 0.0), point("left", 1.2, 0.7)}, reaching(1.2, 1.4, 1.0).transpose()};
    return task.attempt(arm, Scene{obstacles},
                        {.level = Level::kPath, .ik = {}, .planner = {.max_iterations = 400}, .witness = {witness}});
  }
  [[nodiscard]] double clearance(const Eigen::VectorXd& q) const {
    Work work;
    return Scene{obstacles}.clearance(arm, arm.forward(q), work);
  }

  Chain chain = planar_arm(2.0);
  Arm arm = arm_of(chain);
  std::vector<Obstacle> obstacles;
};

TEST_F(ElbowInARing, IsLedThroughAnotherPostureWhereTheClearestOneCannotBeMovedTo) {
  const Eigen::RowVector2d clear_one = reaching(1.2, 0.0, -1.0);
  const Eigen::RowVector2d near_one = reaching(1.2, 0.0, 1.0);
  // A ball 0.2 m behind the elbow that points down, so that the other side has more room at the first goal.
  obstacles.push_back(ball("behind", 0.6 * 1.2, -0.8 * 1.2, 0.05));
  ASSERT_LT(clearance(near_one), clearance(clear_one));
  ASSERT_GT(clearance(near_one), 0.0);
  const Attempt result = planned();
  ASSERT_TRUE(result.achieved) << name(result.why);
  EXPECT_LE((result.postures.row(0) - near_one).cwiseAbs().maxCoeff(), 1e-2);
  EXPECT_GT(result.postures(1, 1), 0.0);
  EXPECT_FALSE(result.missing_motion);
  for (Eigen::Index goal = 0; goal < 2; ++goal) {
    EXPECT_EQ(result.path->waypoints.row(result.goal_waypoints[static_cast<std::size_t>(goal)]),
              result.postures.row(goal));
  }
  EXPECT_EQ(result.clearance, std::min(clearance(result.postures.row(0)), clearance(result.postures.row(1))));
}

TEST_F(ElbowInARing, SaysWhichMotionIsMissingWhereNoPostureHelps) {
  // A ball on the elbow that points down at the first goal: what is free there is on the other side.
  obstacles.push_back(ball("at", 0.6 * 0.8, -0.8 * 0.8, 0.05));
  ASSERT_LT(clearance(reaching(1.2, 0.0, 1.0)), 0.0);
  const Attempt result = planned();
  EXPECT_TRUE(result.reached);
  EXPECT_EQ(result.why, Failure::kNoPath);
  ASSERT_TRUE(result.missing_motion);
  EXPECT_EQ(*result.missing_motion, std::pair(-1, 0));  // from home to the first goal
  EXPECT_LT(result.postures(0, 1), 0.0);
}

TEST_F(ElbowInARing, IsLedThroughTheWitnessThatItCanBeMovedTo) {
  Eigen::MatrixXd witness(2, 2);
  witness << reaching(1.2, 0.0, 1.0), reaching(1.2, 0.7, 1.0);
  const Attempt result = planned(witness);
  ASSERT_TRUE(result.achieved) << name(result.why);
  EXPECT_EQ(result.postures, witness);
  // On the other side nothing else is tried: the evaluation does that, without the witness.
  witness.row(0) = reaching(1.2, 0.0, -1.0);
  EXPECT_EQ(planned(witness).why, Failure::kNoPath);
}

}  // namespace
}  // namespace modsearch
