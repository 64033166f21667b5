#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>

#include "problem/drawn_reach.hpp"
#include "problem/planar_arm.hpp"

namespace modsearch {
namespace {

using testing::arm_of;
using testing::ball;
using testing::planar_arm;
using testing::point;
using testing::reaching;

const GoalTask kTwoGoals{"two", {point("1", 1.2, 0.3), point("2", 1.5, -0.8)}};

Attempt attempt_with(const Task& task, const Chain& chain, Eigen::MatrixXd postures, const Scene& scene = {},
                     Level level = Level::kPostureSelf) {
  return task.attempt(arm_of(chain), scene,
                      {.level = level, .ik = {}, .planner = {}, .witness = {std::move(postures)}});
}

Eigen::MatrixXd rows(const Eigen::RowVectorXd& first, const Eigen::RowVectorXd& second) {
  Eigen::MatrixXd result(2, first.size());
  result << first, second;
  return result;
}

TEST(Witness, IsTakenAsItIsAndNothingElseIsSoughtAfter) {
  const Chain chain = planar_arm();
  // Neither search would give both sides by itself: without obstacles the first of two equal postures counts.
  const Eigen::MatrixXd given = rows(reaching(1.2, 0.3, 1.0), reaching(1.5, -0.8, -1.0));
  const Attempt result = attempt_with(kTwoGoals, chain, given);
  EXPECT_TRUE(result.achieved);
  EXPECT_EQ(result.postures, given);
  EXPECT_EQ(result.work.ik_iterations, 0);
  EXPECT_LE(result.goal_error, 1e-12);
}

TEST(Witness, ThatMissesAGoalIsAMissOfThatGoal) {
  // The second row is 0.2 m short of a goal 1.5 m away: the mean over two goals of 0.2 / 1.5.
  const Eigen::MatrixXd given = rows(reaching(1.2, 0.3, 1.0), reaching(1.3, -0.8, -1.0));
  const Attempt result = attempt_with(kTwoGoals, planar_arm(), given);
  EXPECT_FALSE(result.reached);
  EXPECT_EQ(result.why, Failure::kUnreachable);
  EXPECT_NEAR(result.relative_error, 0.5 * 0.2 / 1.5, 1e-9);
  EXPECT_NEAR(result.goal_error, 0.2, 1e-9);
}

TEST(Witness, OutsideTheLimitsCountsAsTheNearestPostureWithinThem) {
  const double limit = 1.5;  // the elbow needs 2 acos(0.6) = 1.85 rad for 1.2 m
  const Eigen::MatrixXd given = rows(reaching(1.2, 0.3, 1.0), reaching(1.5, -0.8, -1.0));
  ASSERT_GT(given(0, 1), limit);
  ASSERT_LT(-given(1, 1), limit);
  const Attempt result = attempt_with(kTwoGoals, planar_arm(limit), given);
  EXPECT_FALSE(result.reached);
  EXPECT_EQ(result.why, Failure::kLimit);
  EXPECT_EQ(result.postures.row(0), Eigen::RowVector2d(given(0, 0), limit));
  EXPECT_EQ(result.postures.row(1), given.row(1));
}

TEST(Witness, OfAnotherSizeOrNotFiniteIsNotLookedAt) {
  const Chain chain = planar_arm();
  const Attempt plain = attempt_with(kTwoGoals, chain, {});
  ASSERT_TRUE(plain.achieved);
  Eigen::MatrixXd hole = rows(reaching(1.2, 0.3, 1.0), reaching(1.5, -0.8, -1.0));
  hole(1, 1) = std::numeric_limits<double>::quiet_NaN();
  for (const Eigen::MatrixXd& given :
       {Eigen::MatrixXd(Eigen::MatrixXd::Zero(1, 2)), Eigen::MatrixXd(Eigen::MatrixXd::Zero(2, 3)), hole}) {
    EXPECT_EQ(attempt_with(kTwoGoals, chain, given).postures, plain.postures);
  }
}

TEST(Witness, IsLookedAtForCollisionsLikeAnyOtherPosture) {
  // A ball where the elbow would be on the positive side, (cos, sin) of 0.3 - acos(0.6).
  const Eigen::RowVector2d hit = reaching(1.2, 0.3, 1.0);
  const Scene scene{{ball("ball", 0.8 * std::cos(hit[0]), 0.8 * std::sin(hit[0]), 0.1)}};
  const GoalTask task{"one", {point("1", 1.2, 0.3)}};
  const Attempt result = attempt_with(task, planar_arm(), hit, scene);
  EXPECT_TRUE(result.reached);
  EXPECT_EQ(result.why, Failure::kObstacle);
  EXPECT_LT(result.clearance, 0.0);
  // The tip's side of the other link is far away: its posture is free.
  const Attempt other = attempt_with(task, planar_arm(), reaching(1.2, 0.3, -1.0), scene);
  EXPECT_TRUE(other.achieved);
  EXPECT_GT(other.clearance, 0.0);
}

TEST(Witness, SaysOnWhichBranchATrajectoryIsFollowed) {
  const Eigen::Vector3d from{1.2, -0.6, 0.0};
  FollowStep seam = follow("seam", {{PoseRegion::ball(from, 1e-3), PoseRegion::ball({1.2, 0.6, 0.0}, 1e-3)}}, 0);
  const GoalTask task{{.name = "seam", .goals = seam.goals, .steps = {seam.step}}};
  const Chain chain = planar_arm();
  const auto n_goals = static_cast<Eigen::Index>(seam.goals.size());
  for (const double side : {1.0, -1.0}) {
    const Eigen::RowVector2d begin = reaching(from.norm(), std::atan2(from.y(), from.x()), side);
    const Attempt result = attempt_with(task, chain, begin.replicate(n_goals, 1));
    ASSERT_TRUE(result.achieved) << name(result.why);
    const Eigen::MatrixXd& followed = result.trajectories[0];
    EXPECT_TRUE((side * followed.col(1).array() > 0.0).all()) << "the elbow stays on the side that was given";
    // The postures that are reported lead along the same way again.
    EXPECT_EQ(attempt_with(task, chain, result.postures).trajectories[0], followed);
  }
}

// Six drives and three full poses, which a search of one step from one start does not find.
class WitnessedProblem : public ::testing::Test {
 protected:
  WitnessedProblem() {
    RobotProblemSpec spec = load_problem_file("whitman/3g_3o").instance({0, 0})->spec();
    spec.ik.starts = 1;
    spec.ik.iterations = 1;
    spec.level = Level::kPostureSelf;
    testing::DrawnReach drawn = testing::drawn_reach(std::move(spec), Rng{5}).value();
    design = std::move(drawn.design);
    postures = std::move(drawn.postures);
    problem = std::move(drawn.problem);
  }

  Design design;
  Eigen::MatrixXd postures;
  std::unique_ptr<RobotProblem> problem;
};

TEST_F(WitnessedProblem, IsAchievedWithPosturesThatTheEvaluationDoesNotFind) {
  EXPECT_FALSE(problem->evaluate(design).attempt.reached);
  const Evaluation with = problem->evaluate(design, Fidelity::kFull, {postures});
  EXPECT_TRUE(with.attempt.achieved);
  EXPECT_EQ(with.attempt.postures, postures);
}

TEST_F(WitnessedProblem, IsNeverWorseForAWitness) {
  const Evaluation plain = problem->evaluate(design);
  Rng rng{6};
  for (int i = 0; i < 20; ++i) {
    Eigen::MatrixXd wrong = postures;
    for (double& angle : wrong.reshaped()) angle = rng.uniform(-1.0, 1.0);
    EXPECT_FALSE(plain.better_than(problem->evaluate(design, Fidelity::kFull, {wrong})));
  }
}

}  // namespace
}  // namespace modsearch
