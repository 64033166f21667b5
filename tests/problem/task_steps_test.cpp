#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/kinematics/space_time.hpp>
#include <modsearch/problem/task.hpp>
#include <numbers>

namespace modsearch {
namespace {

constexpr double kPi = std::numbers::pi;

Eigen::Isometry3d at(double x, double y, double z) { return Eigen::Isometry3d{Eigen::Translation3d{x, y, z}}; }

struct Limits {
  double position = kPi;
  double velocity = 1.0;
  double torque = std::numeric_limits<double>::infinity();
};

// Two links of 1 m and 1 kg each, capsules of radius 0.05, whose joints turn about the world's z (flat) or -y
// (upright).
Chain two_links(const Limits& limits = {}, bool upright = false) {
  ChainBuilder builder{0};
  if (upright) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();  // z of the joints along -y
    X.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    builder.move(X);
  }
  Eigen::Isometry3d along_x = at(0.5, 0, 0);
  along_x.linear() = Eigen::AngleAxisd{kPi / 2, Eigen::Vector3d::UnitY()}.toRotationMatrix();
  const AffineShape capsule{AffineShape::Kind::kCapsule, {0.05, 0.8}, nullptr};
  for (const char* name : {"a", "b"}) {
    builder.joint({.name = name,
                   .lower = -limits.position,
                   .upper = limits.position,
                   .velocity = limits.velocity,
                   .peak_torque = limits.torque});
    builder.body(name, 0, 1.0, {{capsule, along_x}}, {.X_FB = at(0.5, 0, 0), .r_com = {}});
    builder.move(at(1, 0, 0));
  }
  return builder.build();
}

Goal point(const std::string& id, double radius, double angle) {
  return {id, GoalType::kReach, PoseRegion::ball({radius * std::cos(angle), radius * std::sin(angle), 0.0}, 1e-3)};
}

Attempt attempt(const Task& task, const Chain& chain, Level level, const Scene& scene = {}) {
  return task.attempt(chain.at(Eigen::VectorXd{0}), scene, {.level = level, .ik = {}, .planner = {}, .follow = {}});
}

GoalTask follow_task(const Eigen::Vector3d& from, const Eigen::Vector3d& to, std::vector<double> times = {}) {
  FollowStep seam = follow("seam", {{PoseRegion::ball(from, 1e-3), PoseRegion::ball(to, 1e-3)}, std::move(times)}, 0);
  return GoalTask{{.name = "seam", .goals = seam.goals, .steps = {seam.step}}};
}

TEST(FollowTask, IsFollowedPoseByPoseOnOneBranch) {
  const GoalTask task = follow_task({1.2, -0.6, 0.0}, {1.2, 0.6, 0.0});
  const Chain chain = two_links();
  const Arm arm = chain.at(Eigen::VectorXd{0});
  const Attempt result = attempt(task, chain, Level::kPath);
  ASSERT_TRUE(result.achieved) << name(result.why);
  const TaskStep& step = task.steps()[0];
  ASSERT_EQ(result.trajectories.size(), 1U);
  const Eigen::MatrixXd& rows = result.trajectories[0];
  ASSERT_EQ(rows.rows(), 61);  // 1.2 m in steps of 20 mm
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    const Eigen::VectorXd q = rows.row(k).transpose();
    EXPECT_NEAR(arm.forward(q).tip.translation().x(), 1.2, 1e-3);
    EXPECT_TRUE(step.trajectory->poses[static_cast<std::size_t>(k)].contains(arm.forward(q).tip));
    EXPECT_GT(q[1] * rows(0, 1), 0.0) << "the elbow stays on its side";
  }
  EXPECT_LT((rows.bottomRows(60) - rows.topRows(60)).cwiseAbs().maxCoeff(), 0.1);
  for (std::size_t k = 0; k < step.knots.size(); ++k) {
    EXPECT_EQ(result.postures.row(static_cast<Eigen::Index>(k)), rows.row(step.knots[k]));
  }
  // The path runs through all of them.
  const Eigen::MatrixXd& path = result.path->waypoints;
  EXPECT_EQ(path.bottomRows(61), rows);
  EXPECT_EQ(result.step_waypoints[0], static_cast<int>(path.rows()) - 1);
  EXPECT_TRUE(result.path->times.empty());
}

// Once around a circle of 1.5 m, beginning at 90 degrees, either way. Joints that turn two and a half times around meet
// it from where inverse kinematics finds them, within half a turn of 0, or a turn back: with 360 degrees to either side
// the shoulder has to begin a turn back, for it goes on by a whole one.
TEST(FollowTask, BeginsATurnBackWhereAJointWouldRunIntoItsLimit) {
  for (const double way : {1.0, -1.0}) {
    std::vector<PoseRegion> poses;
    for (int k = 0; k <= 72; ++k) {
      const double angle = 0.5 * kPi + way * 2.0 * kPi * k / 72.0;
      poses.push_back(PoseRegion::ball({1.5 * std::cos(angle), 1.5 * std::sin(angle), 0.0}, 1e-3));
    }
    FollowStep circle = follow("circle", {std::move(poses), {}}, 0);
    const GoalTask task{{.name = "circle", .goals = circle.goals, .steps = {circle.step}}};
    const Chain chain = two_links({.position = 2.0 * kPi});
    const Attempt result = attempt(task, chain, Level::kPosture);
    ASSERT_TRUE(result.achieved) << way << ": " << name(result.why);
    const Eigen::MatrixXd& rows = result.trajectories[0];
    EXPECT_NEAR(rows(rows.rows() - 1, 0) - rows(0, 0), way * 2.0 * kPi, 1e-3);
    EXPECT_LE(rows.cwiseAbs().maxCoeff(), 2.0 * kPi);
    const Chain too_narrow = two_links({.position = 0.9 * kPi});
    EXPECT_FALSE(attempt(task, too_narrow, Level::kPosture).achieved) << "where less than a whole turn is possible";
  }
}

TEST(FollowTask, SaysWhichPartWasNotFollowed) {
  // Beyond 2 m, where the line from (1, 0) to (3, 0) is half done, the arm is too short.
  const Attempt result = attempt(follow_task({1.0, 0.0, 0.0}, {3.0, 0.0, 0.0}), two_links(), Level::kNone);
  EXPECT_FALSE(result.reached);
  EXPECT_EQ(result.why, Failure::kUnreachable);
  EXPECT_NEAR(result.relative_error, 0.5, 0.05);
  const Attempt nowhere = attempt(follow_task({2.5, 0.0, 0.0}, {3.0, 0.0, 0.0}), two_links(), Level::kNone);
  EXPECT_EQ(nowhere.why, Failure::kProvedInfeasible);
  EXPECT_GT(nowhere.relative_error, 1.0);
}

// Along the line the tip moves at 1.2 m / 2 s; near x = 1.2 m the joints need more than 0.3 rad/s for that.
TEST(FollowTask, HasALimitOfVelocityWhereItIsTimed) {
  const GoalTask task = follow_task({1.2, -0.6, 0.0}, {1.2, 0.6, 0.0}, {0.0, 2.0});
  EXPECT_EQ(attempt(task, two_links({.velocity = 0.3}), Level::kNone).why, Failure::kLimit);
  const Attempt slow = attempt(task, two_links({.velocity = 2.0}), Level::kPath);
  ASSERT_TRUE(slow.achieved);
  const std::vector<double>& times = slow.path->times;
  ASSERT_EQ(times.size(), static_cast<std::size_t>(slow.path->waypoints.rows()));
  EXPECT_NEAR(times.back() - times[times.size() - 61], 2.0, 1e-9);
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
}

TEST(FollowTask, IsNotAchievedThroughAnObstacle) {
  const GoalTask task = follow_task({1.2, -0.6, 0.0}, {1.2, 0.6, 0.0});
  const Scene scene{{{"ball", {{Sphere{0.05}, at(1.2, 0.0, 0.0)}}}}};
  const Attempt result = attempt(task, two_links(), Level::kPosture, scene);
  EXPECT_TRUE(result.reached);
  EXPECT_EQ(result.why, Failure::kObstacle);
  EXPECT_LT(result.clearance, 0.0);
}

TEST(GoalTask, TellsLimitsAndProofsFromTheRest) {
  const GoalTask behind{"t", {point("1", 1.5, 2.5)}};
  EXPECT_EQ(attempt(behind, two_links({.position = 1.0}), Level::kNone).why, Failure::kLimit);
  EXPECT_TRUE(attempt(behind, two_links(), Level::kNone).achieved);
  const GoalTask far{"t", {point("1", 2.1, 0.0)}};
  EXPECT_EQ(attempt(far, two_links(), Level::kNone).why, Failure::kProvedInfeasible);
}

// Goals on one circle, so that only the first joint has to move: at 2, -1 and 1 rad beyond what the elbow adds.
// Two links of 1 m: exact inverse kinematics. A point 3 m away is out of reach, one at 1 m is reached in two postures,
// and a ball of 0.6 m about it overlaps both: others within the tolerance were not looked at.
TEST(GoalTask, CallsAVerdictInconclusiveWhereASearchGaveUp) {
  const Chain chain = two_links();
  const auto tried = [&](const Goal& goal, const Scene& scene, Level level, Eigen::VectorXd home = {}) {
    return attempt(GoalTask{"task", {goal}, std::move(home)}, chain, level, scene);
  };
  EXPECT_FALSE(tried(point("far", 3.0, 0.0), {}, Level::kNone).inconclusive);
  EXPECT_FALSE(tried(point("near", 1.0, 0.0), {}, Level::kNone).inconclusive) << "it is achieved";
  const Scene blocked{{{"ball", {{Sphere{0.6}, at(1.0, 0.0, 0.0)}}}}};
  const Attempt hit = tried(point("near", 1.0, 0.0), blocked, Level::kPosture);
  EXPECT_EQ(hit.why, Failure::kObstacle);
  EXPECT_TRUE(hit.inconclusive);
  const Goal pose{"pose", GoalType::kReach, PoseRegion::with_default_tolerances(at(1.0, 0.0, 0.5))};
  EXPECT_TRUE(tried(pose, {}, Level::kNone).inconclusive) << "inverse kinematics for poses is numerical";
  const Scene at_home{{{"ball", {{Sphere{0.3}, at(-1.0, 0.0, 0.0)}}}}};
  const Eigen::Vector2d home{kPi, 0.0};
  const Attempt cannot_begin = tried(point("near", 1.5, 0.0), at_home, Level::kPath, home);
  EXPECT_EQ(cannot_begin.why, Failure::kHomeInCollision);
  EXPECT_FALSE(cannot_begin.inconclusive) << "the task asks for that home";
}

TEST(AnyOrder, IsTheShortestOne) {
  const std::vector<Goal> goals{point("far", 1.9, 2.0), point("back", 1.9, -1.0), point("near", 1.9, 1.0)};
  const Chain chain = two_links();
  const Attempt given = attempt(GoalTask{"given", goals}, chain, Level::kPath);
  const Attempt free = attempt(GoalTask{{.name = "free", .goals = goals, .any_order = true}}, chain, Level::kPath);
  ASSERT_TRUE(given.achieved && free.achieved);
  EXPECT_EQ(free.postures, given.postures);
  EXPECT_TRUE(std::is_sorted(given.goal_waypoints.begin(), given.goal_waypoints.end()));
  EXPECT_LT(free.goal_waypoints[1], free.goal_waypoints[2]);
  EXPECT_LT(free.goal_waypoints[2], free.goal_waypoints[0]);
  const auto length = [](const Path& path) {
    double sum = 0.0;
    for (Eigen::Index i = 1; i < path.waypoints.rows(); ++i) {
      sum += (path.waypoints.row(i) - path.waypoints.row(i - 1)).cwiseAbs().maxCoeff();
    }
    return sum;
  };
  EXPECT_LT(length(*free.path), length(*given.path) - 0.5);
}

TEST(Steps, PauseAndReturn) {
  GoalTaskSpec spec{.name = "cycle", .goals = {point("a", 1.5, 1.0), point("b", 1.2, -1.0)}};
  using Kind = TaskStep::Kind;
  spec.steps = {{.id = "a", .kind = Kind::kVisit, .goal = 0},
                {.id = "rest", .kind = Kind::kPause, .duration = 0.7},
                {.id = "b", .kind = Kind::kVisit, .goal = 1},
                {.id = "again", .kind = Kind::kReturn, .goal = 0},
                {.id = "home", .kind = Kind::kReturn, .goal = -1}};
  const Attempt result = attempt(GoalTask{spec}, two_links(), Level::kPath);
  ASSERT_TRUE(result.achieved) << name(result.why);
  const Eigen::MatrixXd& q = result.path->waypoints;
  const std::vector<double>& t = result.path->times;
  const std::vector<int>& done = result.step_waypoints;
  ASSERT_EQ(done.size(), 5U);
  EXPECT_TRUE(std::is_sorted(done.begin(), done.end()));
  const auto time = [&](std::size_t step) { return t[static_cast<std::size_t>(done[step])]; };
  EXPECT_NEAR(time(1) - time(0), 0.7, 1e-12);
  EXPECT_EQ(q.row(done[1]), q.row(done[0]));
  EXPECT_EQ(q.row(done[3]), result.postures.row(0));
  EXPECT_TRUE(q.row(done[4]).isZero(0.0));
  for (std::size_t i = 1; i < t.size(); ++i) {  // 1 rad/s at most
    const auto row = static_cast<Eigen::Index>(i);
    EXPECT_LE((q.row(row) - q.row(row - 1)).cwiseAbs().maxCoeff(), t[i] - t[i - 1] + 1e-9);
  }
}

TEST(Steps, ThatMakeNoSenseAreRefused) {
  using Kind = TaskStep::Kind;
  const std::vector<Goal> goals{point("a", 1.5, 1.0), point("b", 1.2, -1.0)};
  const TaskStep a{.id = "a", .kind = Kind::kVisit, .goal = 0}, b{.id = "b", .kind = Kind::kVisit, .goal = 1};
  const auto make = [&](std::vector<TaskStep> steps) {
    return GoalTask{{.name = "t", .goals = goals, .steps = steps}};
  };
  EXPECT_NO_THROW((void)make({a, b}));
  EXPECT_THROW((void)make({a}), std::invalid_argument) << "b is forgotten";
  EXPECT_THROW((void)make({a, a, b}), std::invalid_argument);
  EXPECT_THROW((void)make({{.id = "r", .kind = Kind::kReturn, .goal = 1}, a, b}), std::invalid_argument);
  EXPECT_THROW((void)make({a, b, {.id = "p", .kind = Kind::kPause, .duration = -1.0}}), std::invalid_argument);
  EXPECT_THROW((void)make({a, b, {.id = "c", .kind = Kind::kVisit, .goal = 2}}), std::invalid_argument);
}

// Stretched out upright the arm holds 1 kg at 0.5 m and 1 kg at 1.5 m: 2 g = 19.62 N m, and 1.95 m of payload.
TEST(Torque, IsAReasonOfItsOwnAndGrowsWithThePayload) {
  const Goal goal{"1", GoalType::kReach, PoseRegion::ball({1.9, 0.0, 0.0}, 1e-3)};
  GoalTaskSpec spec{.name = "t", .goals = {goal}, .statics = {.payload = 0.0, .limited = true}};
  const Chain chain = two_links({.torque = 25.0}, true);
  const Attempt light = attempt(GoalTask{spec}, chain, Level::kNone);
  EXPECT_TRUE(light.achieved);
  // The tip is 1.9 m away: the centres of mass lie 0.95 m from the joint on average.
  EXPECT_NEAR(light.torque_share, 9.81 * 1.9 / 25.0, 1e-3);
  spec.statics.payload = 1.0;
  const Attempt heavy = attempt(GoalTask{spec}, chain, Level::kNone);
  EXPECT_TRUE(heavy.reached);
  EXPECT_FALSE(heavy.collides);
  EXPECT_EQ(heavy.why, Failure::kTorque);
  EXPECT_NEAR(heavy.torque_share, 9.81 * (1.9 + 1.9) / 25.0, 1e-3);
  spec.statics.limited = false;
  EXPECT_TRUE(attempt(GoalTask{spec}, chain, Level::kNone).achieved);
}

// To touch (0, 0, 1.2) the elbow may point either way; a force to the left is held by pointing... either way alike, but
// a torque of the tip is not: only postures that hold are taken.
TEST(Torque, ChoosesThePostureThatHolds) {
  Goal goal{"1", GoalType::kReach, PoseRegion::ball({1.2, 0.0, 0.0}, 1e-3)};
  GoalTaskSpec spec{.name = "t", .goals = {goal}, .statics = {.gravity = {-9.81, 0.0, 0.0}, .limited = true}};
  const Chain chain = two_links({.torque = 8.5}, true);
  // Gravity along -x: elbow up or down gives joint b the moment -+ 9.81 * (its centre's height over the elbow), alike
  // in size; a push on the tip along z breaks the tie.
  spec.goals[0].wrench.force = {0.0, 0.0, 0.0};
  spec.goals[0].wrench.torque = {0.0, 4.0, 0.0};
  const Arm arm = chain.at(Eigen::VectorXd{0});
  const double b = std::acos((1.2 * 1.2 - 2.0) / 2.0);
  double least = 1e9, most = 0.0;
  for (const double side : {1.0, -1.0}) {
    const Posture posture = arm.forward(Eigen::Vector2d{-0.5 * side * b, side * b});
    const double share =
        torque_share(chain, static_torques(arm, posture, {spec.statics.gravity, 0.0, spec.goals[0].wrench}));
    least = std::min(least, share);
    most = std::max(most, share);
  }
  ASSERT_LT(least, 1.0);
  ASSERT_GT(most, 1.0);
  const Attempt result = attempt(GoalTask{spec}, chain, Level::kNone);
  EXPECT_TRUE(result.achieved);
  EXPECT_NEAR(result.torque_share, least, 1e-3);
}

// A ball stands in the way until it rises after 4 s.
TEST(MovingObstacle, IsMetInTimeOnlyAtLevelPath) {
  Obstacle ball{"ball", {{Sphere{0.2}, at(1.7, 0.0, 0.0)}}};
  ball.motion = {{4.0, 5.0}, {at(0, 0, 0), at(0, 0, 3)}};
  const Scene scene{{ball}};
  const GoalTask task{"t", {point("1", 1.9, 1.0)}, Eigen::Vector2d{-1.0, 0.0}};
  const Chain chain = two_links();
  const Attempt screened = attempt(task, chain, Level::kPostureSelf, scene);
  EXPECT_TRUE(screened.achieved);
  const Attempt result = attempt(task, chain, Level::kPath, scene);
  ASSERT_TRUE(result.achieved) << name(result.why);
  ASSERT_FALSE(result.path->times.empty());
  EXPECT_TRUE(check_in_time(chain.at(Eigen::VectorXd{0}), scene, *result.path, 1e-3).free);

  // Where it never moves away, there may be another way round, above it: none in the plane.
  Obstacle wall{"wall", {{Box{{0.1, 0.1, 4.0}}, at(0.5, 0.0, 0.0)}}};
  wall.motion = {{0.0}, {at(0, 0, 0)}};
  const GoalTask across{"t", {point("1", 1.9, 0.6)}, Eigen::Vector2d{-0.6, 0.0}};
  AttemptOptions options{.level = Level::kPath, .ik = {}, .planner = {.max_iterations = 100}, .follow = {}};
  const Attempt blocked = across.attempt(two_links({.position = 1.0}).at(Eigen::VectorXd{0}), Scene{{wall}}, options);
  EXPECT_EQ(blocked.why, Failure::kNoPath);
}

}  // namespace
}  // namespace modsearch
