#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/problem/nearest_miss.hpp>
#include <numbers>

namespace modsearch {
namespace {

using ::testing::StartsWith;

Goal point(const std::string& id, const Eigen::Vector3d& p_W) {
  return {id, GoalType::kReach, PoseRegion::ball(p_W, 1e-3)};
}

Obstacle ball(const std::string& name, const Eigen::Vector3d& p_W, double radius = 0.1) {
  return {name, {{Sphere{radius}, Eigen::Isometry3d{Eigen::Translation3d{p_W}}}}};
}

// Library `seed`: a base that turns about z at the origin, links and hinges of cylinders of radius 0.055 m.
struct Problem {
  GoalTaskSpec task{};
  std::vector<Obstacle> obstacles{};
  Level level = Level::kPosture;
  std::string library = "seed";

  [[nodiscard]] RobotProblem made() const {
    RobotProblemSpec spec;
    spec.name = "test";
    spec.library = load_library(library);
    spec.task = std::make_shared<GoalTask>(task);
    spec.scene = std::make_shared<Scene>(obstacles);
    spec.level = level;
    spec.planner.max_iterations = 200;
    return RobotProblem{spec};
  }
};

struct Module {
  std::string type;
  std::vector<double> lengths{};
};

Design design(const RobotProblem& problem, const std::vector<Module>& modules) {
  Design result;
  for (const Module& module : modules) {
    result.modules.push_back(
        {problem.library().find(module.type).value(),
         Eigen::Map<const Eigen::VectorXd>(module.lengths.data(), static_cast<Eigen::Index>(module.lengths.size()))});
  }
  return result;
}

NearestMiss missed(const Problem& made, const std::vector<Module>& modules) {
  const RobotProblem problem = made.made();
  const Design arm = design(problem, modules);
  return nearest_miss(problem, arm, problem.evaluate(arm));
}

TEST(NearestMiss, IsNothingForAnAchievedDesign) {
  const NearestMiss nothing = missed({.task = {.name = "t", .goals = {point("1", {0, 0, 1})}}}, {{"link", {1.0}}});
  EXPECT_TRUE(nothing.misses.empty());
  EXPECT_EQ(nothing.words(), "");
}

// A link of 1 m stands upright, whatever its base does: the tip stays at (0, 0, 1), a 3-4-5 triangle away from goal b.
TEST(NearestMiss, SaysWhichGoalIsOutsideItsToleranceByHowManyMillimetres) {
  const NearestMiss found =
      missed({.task = {.name = "t", .goals = {point("a", {0, 0, 1}), point("b", {0.3, 0, 0.6})}}}, {{"link", {1.0}}});
  ASSERT_EQ(found.misses.size(), 1U);
  const Miss& miss = found.misses[0];
  EXPECT_EQ(miss.why, Failure::kUnreachable);
  EXPECT_EQ(miss.place, "goal b");
  EXPECT_EQ(miss.goal, 1);
  EXPECT_NEAR(miss.away, 0.5, 1e-9);
  EXPECT_NEAR(miss.distance, 0.5 - 0.001, 1e-9);
  EXPECT_EQ(miss.angle, 0.0);
  EXPECT_EQ(found.words(), "goal b: 499 mm outside its tolerance");
}

// The tip turns about z only; a pose tilted by 30 degrees about x is never nearer than that, half a degree allowed.
TEST(NearestMiss, SaysByHowManyDegreesAPoseIsTilted) {
  Eigen::Isometry3d X = Eigen::Isometry3d{Eigen::Translation3d{0, 0, 1}};
  X.linear() = Eigen::AngleAxisd{std::numbers::pi / 6, Eigen::Vector3d::UnitX()}.toRotationMatrix();
  const Goal tilted{"1", GoalType::kReach, PoseRegion::with_default_tolerances(X)};
  const NearestMiss found = missed({.task = {.name = "t", .goals = {tilted}}}, {{"link", {1.0}}});
  ASSERT_EQ(found.misses.size(), 1U);
  EXPECT_NEAR(found.misses[0].angle * 180.0 / std::numbers::pi, 29.5, 1e-3);
  EXPECT_EQ(found.misses[0].distance, 0.0);
  EXPECT_EQ(found.words(), "goal 1: 29.5 degrees outside its tolerance");
}

TEST(NearestMiss, SaysThatAnArmIsTooShort) {
  const NearestMiss found = missed({.task = {.name = "t", .goals = {point("1", {0, 0, 2.5})}}}, {{"link", {1.0}}});
  ASSERT_EQ(found.misses.size(), 1U);
  EXPECT_EQ(found.misses[0].why, Failure::kProvedInfeasible);
  EXPECT_EQ(found.words(), "goal 1: 1.5 m outside its tolerance: the arm is too short for it, whatever its joints do");
}

// The ball's centre is 0.1 m from the axis of the link: 0.1 + 0.055 - 0.1 m deep. The other ball is less deep in it.
TEST(NearestMiss, NamesThePairThatTouchesAndItsDepth) {
  const NearestMiss found = missed({.task = {.name = "t", .goals = {point("1", {0, 0, 1})}},
                                    .obstacles = {ball("near", {0.15, 0, 0.5}), ball("deep", {0.1, 0, 0.5})}},
                                   {{"link", {1.0}}});
  ASSERT_EQ(found.misses.size(), 1U);
  const Miss& miss = found.misses[0];
  EXPECT_EQ(miss.why, Failure::kObstacle);
  ASSERT_TRUE(miss.touch.has_value());
  EXPECT_TRUE(miss.touch->obstacle);
  EXPECT_EQ(miss.touch->other, 1);
  EXPECT_NEAR(miss.touch->depth, 0.055, 1e-9);
  EXPECT_NEAR(miss.touch->p_WA.x(), 0.055, 1e-6);  // the side of the link
  EXPECT_NEAR(miss.touch->p_WB.x(), 0.0, 1e-6);    // the side of the ball
  EXPECT_EQ(found.words(), "goal 1: link (module 1) is 55 mm deep in obstacle deep");
}

// Above a link of 1 m a hinge of 0.5 m and 0.6 m can only get its tip to z = 0.9 by folding back: 0.1 m into the link,
// which is less than the 0.11 m to its side.
TEST(NearestMiss, NamesTwoBodiesOfTheArmThatTouch) {
  const NearestMiss found =
      missed({.task = {.name = "t", .goals = {point("1", {0, 0, 0.9})}}, .level = Level::kPostureSelf},
             {{"link", {1.0}}, {"hinge", {0.5, 0.6}}});
  ASSERT_EQ(found.misses.size(), 1U);
  EXPECT_EQ(found.misses[0].why, Failure::kSelfCollision);
  ASSERT_TRUE(found.misses[0].touch.has_value());
  EXPECT_FALSE(found.misses[0].touch->obstacle);
  EXPECT_NEAR(found.misses[0].touch->depth, 0.1, 1e-3);
  EXPECT_THAT(found.words(), StartsWith("goal 1: link (module 1) and hinge (module 2) overlap by 100 mm"));
}

// A tonne at the tip outweighs the arm: the bent drive has to hold it on its lever, the one about z nothing.
TEST(NearestMiss, NamesTheJointThatCannotHold) {
  Problem made{.task = {.name = "t", .goals = {point("1", {0, 0, 0})}, .statics = {.payload = 1000.0, .limited = true}},
               .library = "workshop"};
  const std::vector<Module> modules{{"adapter_120_60"}, {"drive_60_bent"}, {"link_60", {0.4, 0.0}}, {"gripper_60"}};
  const RobotProblem first = made.made();
  const Design arm = design(first, modules);
  const std::shared_ptr<const Chain> chain = first.chain(arm.types());
  const Posture posture = chain->at(arm.parameters()).forward(Eigen::VectorXd::Constant(1, 1.0));
  made.task.goals = {point("1", posture.tip.translation())};
  const NearestMiss found = missed(made, modules);
  ASSERT_EQ(found.misses.size(), 1U);
  const Eigen::Vector3d lever = posture.tip.translation() - posture.origin(0);
  const double torque = posture.axis(0).dot(lever.cross(Eigen::Vector3d{0.0, 0.0, -9.81 * 1000.0}));
  ASSERT_GT(std::abs(torque), 100.0);
  EXPECT_EQ(found.misses[0].why, Failure::kTorque);
  EXPECT_EQ(found.misses[0].joint, chain->joints()[0].name);
  EXPECT_NEAR(found.misses[0].torque_share, std::abs(torque) / 40.0, 0.01 * std::abs(torque) / 40.0);
  EXPECT_THAT(found.words(), StartsWith("goal 1: joint " + chain->joints()[0].name + " would have to hold"));
}

// The arm points along -y between four balls that leave it no way out: towards each side 0.2 / 0.7 = 0.286 rad off, and
// wide enough to touch their neighbours (2 x 0.155 / 0.7 = 0.44 rad between centres that are 0.404 rad apart).
TEST(NearestMiss, NamesTheLegWithoutAPath) {
  Problem made{.task = {.name = "t", .goals = {point("free", {0, 1, 0.5}), point("caged", {0, -1, 0.5})}},
               .obstacles = {ball("left", {0.2, -0.7, 0.5}), ball("right", {-0.2, -0.7, 0.5}),
                             ball("above", {0, -0.7, 0.7}), ball("below", {0, -0.7, 0.3})},
               .level = Level::kPath};
  const NearestMiss found = missed(made, {{"hinge", {0.5, 1.0}}});
  ASSERT_EQ(found.misses.size(), 1U);
  EXPECT_EQ(found.misses[0].why, Failure::kNoPath);
  EXPECT_EQ(found.misses[0].from, "goal free");
  EXPECT_EQ(found.misses[0].to, "goal caged");
  EXPECT_EQ(found.words(), "no collision-free path was found from goal free to goal caged");
  std::swap(made.task.goals[0], made.task.goals[1]);
  EXPECT_EQ(missed(made, {{"hinge", {0.5, 1.0}}}).words(), "no collision-free path was found from home to goal caged");
}

// Upright at home the arm has the ball's centre on its axis: 0.1 + 0.055 m deep.
TEST(NearestMiss, SaysWhatTheArmTouchesAtHome) {
  const NearestMiss found =
      missed({.task = {.name = "t", .goals = {point("1", {0, 1, 0.5})}, .home = Eigen::VectorXd::Zero(2)},
              .obstacles = {ball("lamp", {0, 0, 1.2})},
              .level = Level::kPath},
             {{"hinge", {0.5, 1.0}}});
  ASSERT_EQ(found.misses.size(), 1U);
  EXPECT_EQ(found.misses[0].why, Failure::kHomeInCollision);
  EXPECT_EQ(found.words(), "home: hinge (module 1) is 155 mm deep in obstacle lamp");
}

TEST(NearestMiss, SaysThatAnEndEffectorIsMissing) {
  const NearestMiss found =
      missed({.task = {.name = "t", .goals = {point("1", {1, 0, 0})}}, .library = "workshop"}, {{"adapter_120_60"}});
  ASSERT_EQ(found.misses.size(), 2U);
  EXPECT_EQ(found.misses[0].why, Failure::kIncomplete);
  EXPECT_EQ(found.misses[0].words, "the design ends without an end effector");
  EXPECT_EQ(found.misses[1].place, "goal 1");
}

// Two hinges reach 1.5 m from (0, 0, 0.5). Along y from 1.01 m to 2 m in 50 steps of 19.8 mm the arm gets to the 24th
// (1.4852 m) and not to the 25th (1.505 m).
TEST(NearestMiss, SaysHowFarATrajectoryWasFollowed) {
  const FollowStep seam =
      follow("seam", {{PoseRegion::ball({0, 1.01, 0.5}, 1e-3), PoseRegion::ball({0, 2.0, 0.5}, 1e-3)}}, 0);
  const NearestMiss found = missed({.task = {.name = "t", .goals = seam.goals, .steps = {seam.step}}},
                                   {{"hinge", {0.5, 0.5}}, {"hinge", {0.5, 0.5}}});
  ASSERT_EQ(found.misses.size(), 1U);
  EXPECT_EQ(found.misses[0].place, "pose 25 of trajectory seam");
  EXPECT_EQ(found.misses[0].goal, 4);                         // knots 0, 7, 14, 21, 28, 35, 42, 50
  EXPECT_NEAR(found.misses[0].away, 1.505 - 1.4852, 1.1e-3);  // it stands within a millimetre of the 24th
}

TEST(NearestMiss, GivesTheReasonAloneWhereThePosturesHaveAnotherShape) {
  const RobotProblem problem = Problem{.task = {.name = "t", .goals = {point("1", {0.3, 0, 0.6})}}}.made();
  const Design arm = design(problem, {{"link", {1.0}}});
  Evaluation evaluation = problem.evaluate(arm);
  evaluation.attempt.postures.resize(0, 0);
  const NearestMiss found = nearest_miss(problem, arm, evaluation);
  ASSERT_EQ(found.misses.size(), 1U);
  EXPECT_EQ(found.words(), name(evaluation.attempt.why));
}

}  // namespace
}  // namespace modsearch
