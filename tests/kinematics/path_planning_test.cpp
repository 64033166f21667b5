#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <modsearch/kinematics/edge_checker_internal.hpp>
#include <modsearch/kinematics/path_free.hpp>
#include <modsearch/kinematics/path_planning.hpp>
#include <sstream>
#include <thread>

#include "kinematics/sample_arms.hpp"

namespace modsearch {
namespace {

using sample::kPi;
using sample::kRadius;
using sample::translation;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Every length 0.5, except where a test says otherwise.
Eigen::VectorXd shortest(const Chain& chain) { return Eigen::VectorXd::Constant(chain.n_parameters(), 0.5); }

bool same_bits(const Path& a, const Path& b) {
  return a.waypoints.rows() == b.waypoints.rows() && a.waypoints.cols() == b.waypoints.cols() &&
         (a.waypoints.array() == b.waypoints.array()).all();
}

// Two hinges on the base, an upper arm of 1 m and a forearm of 0.5 m. Only the forearm reaches the wall at x = 1.2, and
// it must thread a window in it: 0.5 m square about y = 0 at the height of the shoulder, z = 0.5.
struct WindowedWall {
  Chain chain = sample::seed_chain("hh");
  Arm arm = chain.at(shortest(chain));
  Scene scene{{{"wall",
                {{Box{{0.05, 4.0, 0.25}}, translation(1.2, 0, 0.125)},
                 {Box{{0.05, 4.0, 3.5}}, translation(1.2, 0, 2.5)},
                 {Box{{0.05, 1.75, 0.5}}, translation(1.2, 1.125, 0.5)},
                 {Box{{0.05, 1.75, 0.5}}, translation(1.2, -1.125, 0.5)}}}}};
  // A hinge at angle q leans the arm by q from the vertical, towards +x when the base stands at 90 degrees.
  Eigen::VectorXd q_start = Eigen::Vector3d{-kPi / 2, kPi / 2, 1.5};  // away from the wall, forearm hanging down
  Eigen::VectorXd q_goal = Eigen::Vector3d{kPi / 2, kPi / 2, 0.0};    // stretched out through the window
};

TEST(PlanPath, IsAStraightLineInFreeSpace) {
  const Chain chain = sample::seed_chain("hrh");
  const Arm arm = chain.at(shortest(chain));
  const Eigen::VectorXd q_start = Eigen::VectorXd::Zero(4);
  const Eigen::VectorXd q_goal = Eigen::Vector4d{1.0, 0.5, -2.0, 0.3};
  const Plan plan = plan_path(arm, Scene{}, q_start, q_goal);
  ASSERT_EQ(plan.status, PlanStatus::kExact);
  ASSERT_EQ(plan.path.waypoints.rows(), 2);
  EXPECT_EQ(plan.path.waypoints.row(0), q_start.transpose());
  EXPECT_EQ(plan.path.waypoints.row(1), q_goal.transpose());
  EXPECT_EQ(plan.iterations, 0) << "no tree is needed";
}

TEST(PlanPath, StaysWhereStartAndGoalAreOne) {
  const Chain chain = sample::seed_chain("h");
  const Arm arm = chain.at(shortest(chain));
  const Eigen::VectorXd q = Eigen::Vector2d{0.3, 0.2};
  const Plan plan = plan_path(arm, sample::mixed_scene(), q, q);
  ASSERT_EQ(plan.status, PlanStatus::kExact);
  EXPECT_EQ(plan.path.waypoints, (Eigen::MatrixXd(2, 2) << 0.3, 0.2, 0.3, 0.2).finished());
}

TEST(PlanPath, MovesAnArmWithoutJointsNowhere) {
  ChainBuilder builder{0};
  builder.body("post", -1, 0.0,
               {{AffineShape{AffineShape::Kind::kSphere, {AffineScalar{0.1}}, nullptr}, AffinePose{}}});
  const Chain chain = builder.build();
  const Eigen::VectorXd none(0);
  const Plan free = plan_path(chain.at(none), Scene{}, none, none);
  EXPECT_EQ(free.status, PlanStatus::kExact);
  EXPECT_EQ(free.path.waypoints.cols(), 0);
  const Scene ball{{{"ball", {{Sphere{0.1}, translation(0.15, 0, 0)}}}}};
  EXPECT_EQ(plan_path(chain.at(none), ball, none, none).status, PlanStatus::kInvalidStart);
}

TEST(PlanPath, FindsTheWayThroughAWindow) {
  const WindowedWall wall;
  const Plan plan = plan_path(wall.arm, wall.scene, wall.q_start, wall.q_goal);
  ASSERT_EQ(plan.status, PlanStatus::kExact);
  EXPECT_GT(plan.path.waypoints.rows(), 2) << "the straight line is blocked";
  EXPECT_GT(plan.iterations, 0);
  EXPECT_EQ(plan.path.waypoints.row(0), wall.q_start.transpose());
  EXPECT_EQ(plan.path.waypoints.bottomRows(1), wall.q_goal.transpose());
  const PathCheck check = check_path(wall.arm, wall.scene, plan.path, PlanOptions{}.resolution / 10, true);
  EXPECT_TRUE(check.within_limits);
  EXPECT_GT(check.states, 100);
  // Between two states that were looked at no point is farther than half the resolution from where it was seen free.
  EXPECT_GE(check.clearance, -PlanOptions{}.resolution / 2);
  EXPECT_GE(check.self_clearance, 0.0);
}

TEST(PlanPath, SatisfiesACheckTenTimesFinerOnManyScenes) {
  std::mt19937 generator{1};
  const Scene scene = sample::mixed_scene();
  int detours = 0;
  for (const std::string types : {"h", "hh", "rh", "hrh", "hlr"}) {
    const Chain chain = sample::seed_chain(types);
    const Arm arm = chain.at(shortest(chain));
    for (int i = 0; i < 20; ++i) {
      const Eigen::VectorXd q_start = sample::random_joints(chain, generator);
      const Eigen::VectorXd q_goal = sample::random_joints(chain, generator);
      const Plan plan = plan_path(arm, scene, q_start, q_goal, {.max_iterations = 1000});
      if (plan.status != PlanStatus::kExact) continue;
      detours += plan.path.waypoints.rows() > 2 ? 1 : 0;
      const PathCheck coarse = check_path(arm, scene, plan.path, PlanOptions{}.resolution, true);
      EXPECT_TRUE(coarse.free);
      const PathCheck fine = check_path(arm, scene, plan.path, PlanOptions{}.resolution / 10, true);
      EXPECT_TRUE(fine.within_limits);
      EXPECT_GE(fine.clearance, -PlanOptions{}.resolution / 2);
      EXPECT_GE(fine.self_clearance, -PlanOptions{}.resolution / 2);
    }
  }
  EXPECT_GT(detours, 10) << "the sample must hold paths round obstacles";
}

TEST(PlanPath, SaysNotFoundWhenTheGoalIsWalledIn) {
  const Chain chain = sample::seed_chain("h");
  const Arm arm = chain.at(shortest(chain));
  // The forearm points along +x through a short tunnel of four boxes; only a straight pull would free it, which a hinge
  // cannot do.
  const Scene scene{{{"tunnel",
                      {{Box{{0.2, 0.02, 0.2}}, translation(0.3, 0.08, 0.5)},
                       {Box{{0.2, 0.02, 0.2}}, translation(0.3, -0.08, 0.5)},
                       {Box{{0.2, 0.2, 0.02}}, translation(0.3, 0, 0.58)},
                       {Box{{0.2, 0.2, 0.02}}, translation(0.3, 0, 0.42)}}}}};
  // Base at 90 degrees: x of the base frame is y, and the hinge about it bends in the plane of x and z.
  const Eigen::VectorXd q_start = Eigen::Vector2d{kPi / 2, 0.0};
  const Eigen::VectorXd q_goal = Eigen::Vector2d{kPi / 2, kPi / 2};
  ASSERT_NEAR((arm.forward(q_goal).tip.translation() - Eigen::Vector3d(0.5, 0, 0.5)).norm(), 0.0, 1e-12);
  const Plan plan = plan_path(arm, scene, q_start, q_goal, {.max_iterations = 300});
  EXPECT_EQ(plan.status, PlanStatus::kNotFound);
  EXPECT_EQ(plan.path.waypoints.size(), 0);
  EXPECT_EQ(plan.iterations, 300);
  const Plan again = plan_path(arm, scene, q_start, q_goal, {.max_iterations = 300});
  EXPECT_EQ(again.status, PlanStatus::kNotFound);
  EXPECT_EQ(again.work.planner_states, plan.work.planner_states);
  EXPECT_EQ(plan_path(arm, scene, q_start, q_goal, {.max_iterations = 0}).iterations, 0);
}

TEST(PlanPath, SaysWhichEndIsInvalid) {
  const WindowedWall wall;
  // Stretched out, 1.2 rad from the vertical: it meets the wall at z = 0.5 + 1.2 / tan(1.2) = 0.97, above the window.
  const Eigen::VectorXd in_the_wall = Eigen::Vector3d{kPi / 2, 1.2, 0.0};
  ASSERT_FALSE(check_path(wall.arm, wall.scene, {in_the_wall.transpose()}, 0.01, true).free);
  EXPECT_EQ(plan_path(wall.arm, wall.scene, in_the_wall, wall.q_goal).status, PlanStatus::kInvalidStart);
  EXPECT_EQ(plan_path(wall.arm, wall.scene, wall.q_start, in_the_wall).status, PlanStatus::kInvalidGoal);
  const Eigen::VectorXd beyond = Eigen::Vector3d{kPi / 2, 0.0, std::nextafter(kPi, 4.0)};
  EXPECT_EQ(plan_path(wall.arm, Scene{}, beyond, wall.q_goal).status, PlanStatus::kInvalidStart);
  EXPECT_EQ(plan_path(wall.arm, Scene{}, wall.q_start, beyond).status, PlanStatus::kInvalidGoal);
  EXPECT_EQ(plan_path(wall.arm, Scene{}, beyond, beyond).path.waypoints.size(), 0);
}

TEST(PlanPath, NeverTurnsAJointPastItsLimits) {
  // A crane that may turn through [-3, 3] rad, and a post at angle 0: the short way from 3 to -3 across pi is closed by
  // the limits, the long way by the post. With the limits at +-4 rad it turns across pi.
  const auto crane = [](JointType type, double limit) {
    ChainBuilder builder{0};
    builder.joint({.name = "slew", .type = type, .lower = -limit, .upper = limit})
        .move(sample::rotation_about_y(kPi / 2));
    const AffineShape jib{AffineShape::Kind::kCylinder, {AffineScalar{kRadius}, AffineScalar{1.0}}, nullptr};
    builder.body("jib", 0, 0.0, {{jib, translation(0, 0, 0.5)}});
    return builder.build();
  };
  const Scene post{{{"post", {{Cylinder{0.05, 1.0}, translation(0.5, 0, 0)}}}}};
  const Eigen::VectorXd q_start = Eigen::VectorXd::Constant(1, 3.0);
  const Eigen::VectorXd q_goal = Eigen::VectorXd::Constant(1, -3.0);
  const Chain tight = crane(JointType::kRevolute, 3.0);
  EXPECT_EQ(plan_path(tight.at({}), post, q_start, q_goal, {.max_iterations = 200}).status, PlanStatus::kNotFound);
  // The same posture again, written as -3 + 2 pi, is within reach without passing the post.
  const Eigen::VectorXd q_turned = Eigen::VectorXd::Constant(1, -3.0 + 2 * kPi);
  const Chain wide = crane(JointType::kRevolute, 4.0);
  EXPECT_EQ(plan_path(wide.at({}), post, q_start, q_turned, {.max_iterations = 200}).status, PlanStatus::kExact);
  EXPECT_EQ(plan_path(tight.at({}), post, q_start, q_turned).status, PlanStatus::kInvalidGoal);
  // A continuous joint has no limits, but its angle is no more wrapped than any other.
  const Chain continuous = crane(JointType::kContinuous, kInfinity);
  EXPECT_EQ(plan_path(continuous.at({}), post, q_start, q_turned).status, PlanStatus::kExact);
  EXPECT_EQ(plan_path(continuous.at({}), post, q_start, q_goal, {.max_iterations = 200}).status, PlanStatus::kNotFound);
}

TEST(PlanPath, KeepsEveryWaypointWithinTheLimits) {
  std::mt19937 generator{2};
  const Chain chain = sample::seed_chain("hrh", 1.5);
  const Arm arm = chain.at(shortest(chain));
  for (int i = 0; i < 50; ++i) {
    const Plan plan = plan_path(arm, sample::mixed_scene(), sample::random_joints(chain, generator),
                                sample::random_joints(chain, generator), {.max_iterations = 500});
    if (plan.status != PlanStatus::kExact) continue;
    EXPECT_LE(plan.path.waypoints.maxCoeff(), 1.5);
    EXPECT_GE(plan.path.waypoints.minCoeff(), -1.5);
  }
}

TEST(PlanPath, GoesRoundTheArmItself) {
  // A jib of 0.8 m that slews and pitches about the origin, and a post of the same robot at (0, 0.5), 0.5 m high. From
  // +x to -x the limits leave only the way over the post: the jib must pitch up by 45 degrees and its radius at least.
  ChainBuilder builder{0};
  const auto cylinder = [](double length) {
    return AffineShape{AffineShape::Kind::kCylinder, {AffineScalar{kRadius}, AffineScalar{length}}, nullptr};
  };
  builder.body("post", -1, 0.0, {{cylinder(1.0), translation(0, 0.5, 0)}});
  builder.joint({.name = "slew", .lower = -kPi, .upper = kPi});
  builder.move(Eigen::Isometry3d{Eigen::AngleAxisd{-kPi / 2, Eigen::Vector3d::UnitX()}});
  builder.joint({.name = "pitch", .lower = -kPi / 2, .upper = kPi / 2});
  builder.body("jib", 0, 0.0, {{cylinder(0.8), translation(0.4, 0, 0) * sample::rotation_about_y(kPi / 2)}});
  const Chain chain = builder.build();
  const Arm arm = chain.at({});
  const Eigen::VectorXd q_start = Eigen::Vector2d{0, 0};
  const Eigen::VectorXd q_goal = Eigen::Vector2d{kPi, 0};

  const Plan plan = plan_path(arm, Scene{}, q_start, q_goal);
  ASSERT_EQ(plan.status, PlanStatus::kExact);
  EXPECT_LT(plan.path.waypoints.col(1).minCoeff(), -kPi / 4) << "upwards is negative";
  EXPECT_GE(check_path(arm, Scene{}, plan.path, 0.001, true).self_clearance, -0.005);

  const Plan blind = plan_path(arm, Scene{}, q_start, q_goal, {.self_collision = false});
  EXPECT_EQ(blind.path.waypoints.rows(), 2);
  EXPECT_FALSE(check_path(arm, Scene{}, blind.path, 0.001, true).free);
  EXPECT_TRUE(check_path(arm, Scene{}, blind.path, 0.001, false).free);
  Work work;
  EXPECT_FALSE(path_is_free(arm, Scene{}, blind.path, 0.001, true, work)) << "the verdict alone is the same";
  EXPECT_TRUE(path_is_free(arm, Scene{}, blind.path, 0.001, false, work));
}

TEST(PlanPath, SlidesToo) {
  // A sled along x that may slide 2 m, with a mast that a lift along z raises above the fence.
  ChainBuilder builder{0};
  builder.move(sample::rotation_about_y(kPi / 2))
      .joint({.name = "rail", .type = JointType::kPrismatic, .lower = 0, .upper = 2});
  builder.move(sample::rotation_about_y(-kPi / 2))
      .joint({.name = "lift", .type = JointType::kPrismatic, .lower = 0, .upper = 1});
  const AffineShape ball{AffineShape::Kind::kSphere, {AffineScalar{0.1}}, nullptr};
  builder.body("ball", 0, 0.0, {{ball, AffinePose{}}});
  const Chain chain = builder.build();
  const Scene fence{{{"fence", {{Box{{0.1, 1.0, 1.0}}, translation(1.0, 0, 0)}}}}};
  const Plan plan = plan_path(chain.at({}), fence, Eigen::Vector2d{0, 0}, Eigen::Vector2d{2, 0});
  ASSERT_EQ(plan.status, PlanStatus::kExact);
  EXPECT_GE(plan.path.waypoints.col(1).maxCoeff(), 0.5) << "the ball's centre passes above the fence";
  EXPECT_GE(check_path(chain.at({}), fence, plan.path, 0.001, true).clearance, -0.005);
}

TEST(PlanPath, GivesEqualPathsInAnyOrderOfCallsAndFromTwoThreads) {
  const WindowedWall wall;
  const Chain other_chain = sample::seed_chain("hrh");
  const Arm other_arm = other_chain.at(shortest(other_chain));
  const Eigen::VectorXd other_start = Eigen::Vector4d{0, 1.0, 0, 1.0};
  const Eigen::VectorXd other_goal = Eigen::Vector4d{-2.5, 1.0, 1.0, 1.0};
  const auto through_window = [&] { return plan_path(wall.arm, wall.scene, wall.q_start, wall.q_goal); };
  const auto other = [&](std::uint64_t stream) {
    return plan_path(other_arm, sample::mixed_scene(), other_start, other_goal, {.stream = stream});
  };
  const Plan first = through_window();
  ASSERT_EQ(first.status, PlanStatus::kExact);
  const Plan other_first = other(7);
  for (int i = 0; i < 5; ++i) {
    const Plan again = through_window();
    EXPECT_TRUE(same_bits(again.path, first.path));
    EXPECT_EQ(again.iterations, first.iterations);
    EXPECT_EQ(again.work.planner_states, first.work.planner_states);
    EXPECT_EQ(again.work.distances, first.work.distances);
    (void)other(static_cast<std::uint64_t>(i));
    EXPECT_TRUE(same_bits(other(7).path, other_first.path));
  }
  std::vector<Plan> plans(8);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 2; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t i = t; i < plans.size(); i += 2) plans[i] = i % 4 < 2 ? through_window() : other(7);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < plans.size(); ++i) {
    EXPECT_TRUE(same_bits(plans[i].path, (i % 4 < 2 ? first : other_first).path)) << i;
  }
}

TEST(PlanPath, TakesAnotherWayWithAnotherStream) {
  const WindowedWall wall;
  const Plan zero = plan_path(wall.arm, wall.scene, wall.q_start, wall.q_goal, {.stream = 0});
  const Plan one = plan_path(wall.arm, wall.scene, wall.q_start, wall.q_goal, {.stream = 1});
  ASSERT_EQ(zero.status, PlanStatus::kExact);
  ASSERT_EQ(one.status, PlanStatus::kExact);
  EXPECT_FALSE(same_bits(zero.path, one.path));
}

// One line per plan with every bit of the path, for the comparison of processes.
std::string transcript() {
  const WindowedWall wall;
  std::ostringstream text;
  text << std::hexfloat;
  for (std::uint64_t stream = 0; stream < 4; ++stream) {
    const Plan plan = plan_path(wall.arm, wall.scene, wall.q_start, wall.q_goal, {.stream = stream});
    text << plan.iterations << ' ' << plan.work.planner_states;
    for (const double value : plan.path.waypoints.reshaped()) text << ' ' << value;
    text << '\n';
  }
  return text.str();
}

TEST(PlanPath, GivesEqualPathsInAnotherProcess) {
  if (const char* file = std::getenv("MODSEARCH_TRANSCRIPT")) {  // this is the other process
    std::ofstream{file} << transcript();
    return;
  }
  const std::string file = testing::TempDir() + "modsearch_transcript_" + std::to_string(getpid());
  const std::string self = std::filesystem::read_symlink("/proc/self/exe");
  const std::string command = "MODSEARCH_TRANSCRIPT='" + file + "' '" + self +
                              "' --gtest_filter=PlanPath.GivesEqualPathsInAnotherProcess > /dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::ostringstream other;
  other << std::ifstream{file}.rdbuf();
  std::remove(file.c_str());
  EXPECT_EQ(other.str(), transcript());
}

TEST(PlanPath, SaysNothingOnTheConsole) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const WindowedWall wall;
  (void)plan_path(wall.arm, wall.scene, wall.q_start, wall.q_goal);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(PlanPath, RefusesWhatDoesNotFit) {
  const WindowedWall wall;
  const Eigen::VectorXd short_q = Eigen::VectorXd::Zero(2);
  Eigen::VectorXd broken = wall.q_goal;
  broken[1] = std::nan("");
  EXPECT_THROW((void)plan_path(wall.arm, wall.scene, short_q, wall.q_goal), std::invalid_argument);
  EXPECT_THROW((void)plan_path(wall.arm, wall.scene, wall.q_start, short_q), std::invalid_argument);
  EXPECT_THROW((void)plan_path(wall.arm, wall.scene, wall.q_start, broken), std::invalid_argument);
  const auto with = [&](const PlanOptions& options) {
    (void)plan_path(wall.arm, wall.scene, wall.q_start, wall.q_goal, options);
  };
  EXPECT_THROW(with({.max_iterations = -1}), std::invalid_argument);
  EXPECT_THROW(with({.resolution = 0.0}), std::invalid_argument);
  EXPECT_THROW(with({.resolution = kInfinity}), std::invalid_argument);
  EXPECT_THROW(with({.shortcut_attempts = -1}), std::invalid_argument);
  EXPECT_THROW((void)check_path(wall.arm, wall.scene, {Eigen::MatrixXd::Zero(2, 5)}, 0.01, true),
               std::invalid_argument);
  EXPECT_THROW((void)check_path(wall.arm, wall.scene, {broken.transpose()}, 0.01, true), std::invalid_argument);
  EXPECT_THROW((void)check_path(wall.arm, wall.scene, {wall.q_goal.transpose()}, -1.0, true), std::invalid_argument);
}

TEST(PlanStatus, HasNames) {
  EXPECT_EQ(name(PlanStatus::kExact), "exact");
  EXPECT_EQ(name(PlanStatus::kNotFound), "not found");
  EXPECT_EQ(name(PlanStatus::kInvalidStart), "invalid start");
  EXPECT_EQ(name(PlanStatus::kInvalidGoal), "invalid goal");
}

TEST(CheckPath, CallsNoPathNotFree) {
  const Chain chain = sample::seed_chain("h");
  const PathCheck check = check_path(chain.at(shortest(chain)), Scene{}, {}, 0.01, true);
  EXPECT_FALSE(check.free);
  EXPECT_EQ(check.states, 0);
}

TEST(CheckPath, FindsTheLeastClearanceOnTheWay) {
  // One hinge at height 0.5 swings its forearm of 0.5 in the plane x = 0, from straight up to the side, past a ball of
  // radius 0.1 at distance 0.8 from the hinge and 45 degrees. The rim of the forearm's end comes closest.
  const Chain chain = sample::seed_chain("h");
  const Arm arm = chain.at(shortest(chain));
  const double d = 0.8 * std::sqrt(0.5);
  const Scene scene{{{"ball", {{Sphere{0.1}, translation(0, -d, 0.5 + d)}}}}};
  const Path path{(Eigen::MatrixXd(2, 2) << 0, 0, 0, kPi / 2).finished()};
  const PathCheck check = check_path(arm, scene, path, 0.001, true);
  EXPECT_TRUE(check.free);
  const double farthest = std::hypot(0.5, kRadius);
  EXPECT_NEAR(check.clearance, 0.8 - farthest - 0.1, 0.0005) << "some state is half a millimetre away at most";
  // No point moves farther than 1 mm between states; the bound on the farthest point may be a little more than it.
  EXPECT_GE(check.states, 1 + static_cast<int>(std::ceil(kPi / 2 * farthest / 0.001)));
  EXPECT_LE(check.states, 1.02 * kPi / 2 * farthest / 0.001);
  EXPECT_EQ(check.work.planner_states, check.states);
  EXPECT_EQ(check.self_clearance, kInfinity) << "two bodies, and they are neighbours";
}

TEST(CheckPath, SaysWhenALimitIsPassed) {
  const Chain chain = sample::seed_chain("h", 1.0);
  const Path path{(Eigen::MatrixXd(2, 2) << 0, 0, 0, 1.1).finished()};
  const PathCheck check = check_path(chain.at(shortest(chain)), Scene{}, path, 0.01, true);
  EXPECT_FALSE(check.within_limits);
  EXPECT_FALSE(check.free);
}

TEST(MotionBound, HoldsForEveryPointOfEveryBody) {
  std::mt19937 generator{4};
  for (const std::string types : {"h", "hr", "rlh", "rrhh"}) {
    ChainBuilder builder{0};
    const Chain chain = sample::seed_chain(types);
    const Arm arm = chain.at(Eigen::VectorXd::Constant(chain.n_parameters(), 0.7));
    const MotionBound motion(arm, chain.lower_limits(), chain.upper_limits());
    for (int i = 0; i < 500; ++i) {
      const Eigen::VectorXd a = sample::random_joints(chain, generator);
      const Eigen::VectorXd b = a + 0.2 * sample::random_joints(chain, generator);
      const Posture at_a = arm.forward(a);
      const Posture at_b = arm.forward(b);
      double most = 0.0;
      for (const ArmGeometry& geometry : arm.geometries()) {
        const auto frame = static_cast<std::size_t>(geometry.frame);
        const double half = 0.5 * std::get<Cylinder>(geometry.shape).length;
        for (int k = 0; k < 24; ++k) {  // the rims of the cylinder are its farthest points
          const double angle = kPi / 6 * k;
          const Eigen::Vector3d p{kRadius * std::cos(angle), kRadius * std::sin(angle), k < 12 ? half : -half};
          most =
              std::max(most, (at_b.frames[frame] * geometry.X_FG * p - at_a.frames[frame] * geometry.X_FG * p).norm());
        }
      }
      EXPECT_LE(most, motion.travel(a.data(), b.data()) + 1e-12);
    }
  }
}

TEST(EdgeChecker, SkipsOnlyStatesThatAreFree) {
  // The same verdict as looking at every state, from either end.
  std::mt19937 generator{5};
  const Scene scene = sample::mixed_scene();
  constexpr double kResolution = 0.02;
  std::int64_t looked_at = 0;
  std::int64_t all_states = 0;
  int free_edges = 0;
  for (const std::string types : {"h", "hrh", "hhlh"}) {
    const Chain chain = sample::seed_chain(types);
    const Arm arm = chain.at(shortest(chain));
    EdgeChecker checker(arm, scene, chain.lower_limits(), chain.upper_limits(), kResolution, true);
    const MotionBound motion(arm, chain.lower_limits(), chain.upper_limits());
    for (int i = 0; i < 500; ++i) {
      const Eigen::VectorXd a = sample::random_joints(chain, generator);
      const Eigen::VectorXd b = a + 0.3 * (sample::random_joints(chain, generator) - a);
      const std::int64_t n = parts_of(motion.travel(a.data(), b.data()), kResolution);
      bool free = true;
      Eigen::VectorXd q(chain.n_joints());
      Work work;
      for (std::int64_t k = 0; k <= n; ++k) {
        interpolate(a.data(), b.data(), k, n, chain.n_joints(), q.data());
        const Posture posture = arm.forward(q);
        free = free && !scene.collides(arm, posture, work) && !self_collides(arm, posture, work);
      }
      const std::int64_t before = checker.work().planner_states;
      EXPECT_EQ(checker.state_free(a.data()) && checker.edge_free(a.data(), b.data()), free);
      if (free) {
        looked_at += checker.work().planner_states - before;
        all_states += n + 1;
        ++free_edges;
      }
      EXPECT_EQ(checker.state_free(b.data()) && checker.edge_free(b.data(), a.data()), free);
    }
  }
  EXPECT_GT(free_edges, 100);
  EXPECT_LT(2 * looked_at, all_states) << "skipping is worth its while";
}

TEST(EdgeChecker, CutsAnEdgeAtTheSameStatesFromEitherEnd) {
  std::mt19937 generator{6};
  std::uniform_real_distribution<double> angle{-kPi, kPi};
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d a{angle(generator), angle(generator), angle(generator)};
    const Eigen::Vector3d b{angle(generator), angle(generator), angle(generator)};
    Eigen::Vector3d there;
    Eigen::Vector3d back;
    for (const std::int64_t k : {0, 1, 3, 6, 7}) {
      interpolate(a.data(), b.data(), k, 7, 3, there.data());
      interpolate(b.data(), a.data(), 7 - k, 7, 3, back.data());
      EXPECT_EQ(there, back);
    }
    interpolate(a.data(), b.data(), 7, 7, 3, there.data());
    EXPECT_EQ(there, b);
  }
}

}  // namespace
}  // namespace modsearch
