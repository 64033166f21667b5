#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinematics/separation_checks.hpp"
#include "problem/end_tasks.hpp"

namespace modsearch {
namespace {

using test::looseness;
using test::Looseness;
using ::testing::HasSubstr;

RobotProblem problem_of(std::vector<Goal> goals, std::vector<Obstacle> obstacles, const char* library = "workshop",
                        Level level = Level::kPosture) {
  RobotProblemSpec spec = load_problem_file("whitman/3g_3o").spec;
  if (spec.library->name() != library) spec.library = load_library(library);
  spec.task = std::make_shared<GoalTask>("ends", std::move(goals));
  spec.scene = std::make_shared<Scene>(std::move(obstacles));
  spec.level = level;
  return RobotProblem{std::move(spec)};
}

Goal goal_at(const Eigen::Isometry3d& X_WN, std::vector<Tolerance> tolerances, const char* id = "1") {
  return {id, GoalType::kReach, PoseRegion{X_WN, std::move(tolerances)}};
}

constexpr double kAway = 2.0;  // [m]: far from the base

Eigen::Isometry3d above(double z) { return Eigen::Isometry3d{Eigen::Translation3d{kAway, 0.0, z}}; }

std::vector<Tolerance> millimetre_and_half_a_degree() {
  return PoseRegion::with_default_tolerances(Eigen::Isometry3d::Identity()).tolerances();
}

// A block a metre wide whose top is 0.05 m below the tip, which points up: gripper_60 is 0.14 m long, so the end of its
// palm is 0.09 m deep. 1 mm of that is the tolerance of the position, and half a degree carries a point 0.14 m away by
// 2 sin(0.25 deg) 0.14 m. The larger grippers are deeper.
TEST(EndProofs, SayWhichGoalLiesInWhichObstacleForWhichModuleAndHowDeep) {
  const Obstacle block{"block", {{Box{{1.0, 1.0, 1.0}}, above(0.0)}}};
  const RobotProblem problem = problem_of({goal_at(above(2.0), millimetre_and_half_a_degree(), "free"),
                                           goal_at(above(0.55), millimetre_and_half_a_degree(), "in it")},
                                          {block});
  const std::optional<Infeasibility> why = problem.infeasible();
  ASSERT_TRUE(why);
  EXPECT_EQ(why->goal, 1);
  EXPECT_EQ(why->goal_id, "in it");
  EXPECT_EQ(why->obstacle_name, "block");
  EXPECT_EQ(why->module_id, "gripper_60");
  const double turned = 2.0 * std::sin(test::kTurn / 360.0 / 4.0) * 0.14;
  EXPECT_LE(why->depth, 0.09 - 0.001);
  EXPECT_NEAR(why->depth, 0.09 - 0.001 - turned, 1e-4);
  EXPECT_THAT(
      why->reason,
      HasSubstr(
          "goal 'in it' lies in obstacle 'block' for every end effector: gripper_60 overlaps it by at least 87."));
  EXPECT_EQ(problem.optimism_of_length(5).score, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(problem.optimism_of_length(5).reason, why->reason);
}

// The fingers of gripper_60 end at the tip: 0.4 mm below it they are in the block by less than the tolerance.
TEST(EndProofs, ClaimNothingWithinTheTolerance) {
  const Obstacle block{"block", {{Box{{1.0, 1.0, 1.0}}, above(1.1396)}}};  // from 0.6396 on: the tip is at 0.64
  const Eigen::Isometry3d X_WG = above(0.64);
  EXPECT_FALSE(problem_of({goal_at(X_WG, millimetre_and_half_a_degree())}, {block}).infeasible());
  std::vector<Tolerance> exact = millimetre_and_half_a_degree();
  for (Tolerance& tolerance : exact) tolerance.lower = tolerance.upper = 0.0;
  EXPECT_TRUE(problem_of({goal_at(X_WG, exact)}, {block}).infeasible());
}

TEST(EndProofs, ClaimNothingWhereTheLevelIgnoresObstaclesOrTheseMove) {
  Obstacle block{"block", {{Box{{1.0, 1.0, 1.0}}, above(0.0)}}};
  const std::vector<Goal> goals{goal_at(above(0.4), millimetre_and_half_a_degree())};
  EXPECT_TRUE(problem_of(goals, {block}).infeasible());
  EXPECT_FALSE(problem_of(goals, {block}, "workshop", Level::kNone).infeasible());
  block.motion = {{0.0, 1.0}, {Eigen::Isometry3d::Identity(), above(3.0)}};
  EXPECT_FALSE(problem_of(goals, {block}).infeasible());
}

// A tool that may turn about itself and lean by 0.1 rad is on its axis wherever it turns to: 0.14 m behind the tip it
// is off by 0.014 m at most, and 0.09 m deep.
TEST(EndProofs, CoverAFreeAxisAndACone) {
  const Obstacle block{"block", {{Box{{1.0, 1.0, 1.0}}, above(0.0)}}};
  std::vector<Tolerance> cone{
      {Projection::kRSph, 0.0, 1e-3}, {Projection::kNx, -0.1, 0.1}, {Projection::kNy, -0.1, 0.1}};
  const std::optional<Infeasibility> why = problem_of({goal_at(above(0.55), cone)}, {block}).infeasible();
  ASSERT_TRUE(why);
  EXPECT_GT(why->depth, 0.06);
  EXPECT_LE(why->depth, 0.09 - 0.001);
  cone.pop_back();  // it may lean over altogether
  EXPECT_FALSE(problem_of({goal_at(above(0.55), cone)}, {block}).infeasible());
}

// Arms of the reference library end in the disc in which their last cylinder ends, whatever direction it has: a target
// inside an obstacle is out of reach if it is deeper there than its tolerance.
TEST(EndProofs, ClaimThatATargetInsideAnObstacleCannotBeReached) {
  const Obstacle ball{"ball", {{Sphere{0.3}, above(1.0)}}};
  const auto target = [&](double depth) {
    return problem_of({{"t", GoalType::kReach, PoseRegion::ball({kAway, 0.0, 1.3 - depth}, 1e-3)}}, {ball}, "seed");
  };
  const std::optional<Infeasibility> why = target(0.005).infeasible();
  ASSERT_TRUE(why);
  EXPECT_NEAR(why->depth, 0.004, 1e-6);
  EXPECT_THAT(why->reason, HasSubstr("goal 't' lies in obstacle 'ball' for every last module"));
  EXPECT_FALSE(target(0.0005).infeasible());
  EXPECT_FALSE(target(-0.1).infeasible());
}

// The plate of the workshop's base is 0.02 m thick and stands on the ground; its upper part is 0.06 m wide.
TEST(EndProofs, ClaimThatTheBaseStandsInAnObstacle) {
  const std::vector<Goal> goals{goal_at(above(1.0), millimetre_and_half_a_degree())};
  Obstacle wall{"wall", {{Box{{1.0, 1.0, 1.0}}, Eigen::Isometry3d{Eigen::Translation3d{0.6, 0.0, 0.0}}}}};
  const std::optional<Infeasibility> why = problem_of(goals, {wall}).infeasible();
  ASSERT_TRUE(why);
  EXPECT_EQ(why->goal, -1);
  EXPECT_EQ(why->module, -1);
  EXPECT_NEAR(why->depth, 0.12 - 0.1, 2e-4);
  wall.shapes[0].X_FG.translation().x() = 0.6201;
  EXPECT_FALSE(problem_of(goals, {wall}).infeasible());
}

// A slab from z = 0.75 to 0.81 below a tip at z = 1 that points up. gripper_60 ends at 0.86, before it; a link_60
// behind it is a flange as far as 0.84 and a tube of 0.04 to 0.38 m, which is in the slab at every length. With an
// inline drive, whose rotor is 0.044 m long, the end is free, and so is gripper_90, which ends at 0.82.
TEST(EndProofs, RuleOutWhatStandsBehindAnEndEffectorForAllItsLengths) {
  const auto at = [](double z) { return Eigen::Isometry3d{Eigen::Translation3d{0.6, 0.0, z}}; };
  const Obstacle slab{"slab", {{Box{{0.4, 0.4, 0.06}}, at(0.78)}}};
  const RobotProblem problem = problem_of({goal_at(at(1.0), millimetre_and_half_a_degree())}, {slab});
  EXPECT_FALSE(problem.infeasible());
  const auto optimism = [&](const char* before_it) {
    std::vector<int> types;
    for (const char* name : {"link_120", "adapter_120_60", before_it, "gripper_60"}) {
      types.push_back(problem.library().find(name).value());
    }
    return problem.optimism(types);
  };
  EXPECT_EQ(optimism("link_60").score, -std::numeric_limits<double>::infinity());
  EXPECT_THAT(optimism("link_60").reason, HasSubstr("link_60 overlaps obstacle 'slab' at goal '1' by at least"));
  EXPECT_GT(optimism("drive_60_inline").score, 0.0) << optimism("drive_60_inline").reason;
}

// As high as 0.83 the slab is in the way of whatever gripper_60 may be joined to, and of the other grippers.
TEST(EndProofs, FollowFromAllThatMayStandBehindAnEndEffector) {
  const Obstacle slab{"slab", {{Box{{0.4, 0.4, 0.06}}, above(0.8)}}};
  const std::optional<Infeasibility> why =
      problem_of({goal_at(above(1.0), millimetre_and_half_a_degree())}, {slab}).infeasible();
  ASSERT_TRUE(why);
  EXPECT_THAT(why->reason, HasSubstr("no end effector is possible: "));
  EXPECT_THAT(why->reason, HasSubstr("with gripper_60, what is before it: at best "));
}

struct Planted {
  RobotProblem problem;
  std::vector<int> types;
  Eigen::VectorXd x;
};

// A task about an arm whose postures keep clear of every obstacle by 0 to 1 mm; nothing if the obstacles cannot be put
// so.
std::optional<Planted> planted(int n_goals, Rng& rng) {
  const std::shared_ptr<const ModuleLibrary> library = load_library("workshop");
  std::vector<int> types = test::random_sequence(*library, 9, rng);
  const Chain chain = library->assemble(types);
  Eigen::VectorXd x = test::random_parameters(*library, types, rng);
  const Arm arm = chain.at(x);
  std::vector<Goal> goals;
  std::vector<Posture> postures;
  for (int g = 0; g < n_goals; ++g) {
    postures.push_back(arm.forward(test::random_posture(chain, rng)));
    const Looseness loose = looseness(rng.index(test::kLoosenesses), rng);
    // The deviation of the arm from the nominal pose is any that is accepted.
    const Eigen::Isometry3d D = loose.draw(Eigen::Isometry3d::Identity(), rng);
    goals.push_back(goal_at(postures.back().tip * D.inverse(), loose.tolerances, "g"));
    EXPECT_TRUE(goals.back().region.contains(postures.back().tip));
  }
  std::vector<Obstacle> obstacles;
  Work work;
  for (int i = 0; i < 4; ++i) {
    Obstacle obstacle =
        test::random_obstacle(postures[static_cast<std::size_t>(rng.index(n_goals))].tip.translation(), rng);
    const double room = rng.uniform(0.0, 1e-3);
    for (int round = 0; round < 30; ++round) {
      const Scene scene{{obstacle}};
      std::optional<Contact> closest;
      for (const Posture& posture : postures) {
        for (const Contact& contact : scene.contacts(arm, posture, 10.0, work)) {
          if (!closest || contact.separation.distance < closest->separation.distance) closest = contact;
        }
      }
      const double distance = closest->separation.distance;
      if (distance >= 0.0 && distance <= 1e-3) {
        obstacles.push_back(obstacle);
        break;
      }
      obstacle.shapes[0].X_FG.pretranslate(-(room - distance) * closest->separation.normal_W);
    }
  }
  if (obstacles.empty()) return std::nullopt;
  const Scene scene{obstacles};
  for (const Posture& posture : postures) {
    if (scene.clearance(arm, posture, work) < 0.0) return std::nullopt;
  }
  return Planted{problem_of(std::move(goals), std::move(obstacles)), std::move(types), std::move(x)};
}

// What such an arm is worth, if it is found: more than any bound may say.
void expect_nothing_against(int n_tasks, std::uint64_t seed) {
  Rng rng{seed};
  int tasks = 0;
  while (tasks < n_tasks) {
    const std::optional<Planted> task = planted(1 + rng.index(3), rng);
    if (!task) continue;
    ++tasks;
    const RobotProblem& problem = task->problem;
    const std::optional<Infeasibility> why = problem.infeasible();
    ASSERT_FALSE(why) << tasks << ": " << why->reason;
    const auto n = static_cast<int>(task->types.size());
    double cost = problem.library().base().cost;
    for (const int k : task->types) cost += problem.library().type(k).cost;
    const double worth = problem.spec().scoring->bound(n + 1, problem.chain(task->types)->mass(task->x), cost);
    const Optimism own = problem.optimism(task->types);
    ASSERT_GE(own.score, worth - 1e-9) << tasks << ": " << own.reason;
    for (int given = 0; given <= n; ++given) {
      const std::span<const int> prefix{task->types.data(), static_cast<std::size_t>(given)};
      const Optimism optimism = problem.optimism_of_prefix(prefix, n);
      ASSERT_GE(optimism.score, worth - 1e-9) << tasks << ", " << given << " given: " << optimism.reason;
    }
  }
}

TEST(EndProofs, SayNothingAgainst1000TasksWithAnArmThatIsFreeByAMillimetreAtMost) { expect_nothing_against(1000, 1); }
TEST(SlowEndProofs, SayNothingAgainst30000TasksWithAnArmThatIsFreeByAMillimetreAtMost) {
  expect_nothing_against(30'000, 2);
}

// Sequences that are ruled out for an overlap at the only goal, put there: the modules that move with the tip, and
// those that do not move at all.
void expect_overlaps(int n_claims, int n_ends, std::uint64_t seed) {
  using separation_checks::fcl_overlaps;
  Rng rng{seed};
  const std::shared_ptr<const ModuleLibrary> library = load_library("workshop");
  int claims = 0;
  while (claims < n_claims) {
    Eigen::Isometry3d X_WN = Eigen::Isometry3d::Identity();
    X_WN.translation() = test::random_vector(rng, 0.6);
    X_WN.linear() = test::random_rotation(rng);
    const Looseness loose = looseness(rng.index(test::kLoosenesses), rng);
    std::vector<Obstacle> obstacles;
    for (int i = 0; i < 2; ++i) obstacles.push_back(test::random_obstacle(X_WN.translation(), rng));
    const RobotProblem problem = problem_of({goal_at(X_WN, loose.tolerances)}, obstacles);
    for (int sequence = 0; sequence < 5 && claims < n_claims; ++sequence) {
      const std::vector<int> types = test::random_sequence(*library, 9, rng);
      const Optimism optimism = problem.optimism(types);
      if (optimism.reason.find("overlaps") == std::string::npos) continue;
      ++claims;
      const Chain chain = library->assemble(types);
      for (int end = 0; end < n_ends; ++end) {
        const Arm arm = chain.at(test::random_parameters(*library, types, rng));
        const Posture posture = arm.forward(test::random_posture(chain, rng));
        const Eigen::Isometry3d X_WE = loose.draw(X_WN, rng);
        const Eigen::Isometry3d carried = X_WE * posture.tip.inverse();  // the arm, held at its tip
        bool overlaps = false;
        for (const ArmGeometry& geometry : arm.geometries()) {
          const bool at_the_tip = geometry.frame == arm.n_joints();
          if (!at_the_tip && geometry.frame != 0) continue;
          const Eigen::Isometry3d X_WG = posture.frames[static_cast<std::size_t>(geometry.frame)] * geometry.X_FG;
          for (const Obstacle& obstacle : obstacles) {
            const PlacedShape& shape = obstacle.shapes[0];
            if (geometry.frame == 0) overlaps = overlaps || fcl_overlaps(geometry.shape, X_WG, shape.shape, shape.X_FG);
            if (!at_the_tip) continue;
            overlaps = overlaps || fcl_overlaps(geometry.shape, carried * X_WG, shape.shape, shape.X_FG);
          }
          if (overlaps) break;
        }
        ASSERT_TRUE(overlaps) << "claim " << claims << ", end " << end << ": " << optimism.reason << "; "
                              << to_string(*library, make_design(*library, types, arm.parameters()));
      }
    }
  }
}

TEST(EndProofs, AreRightAbout4000EndsPutAtTheGoalByFcl) { expect_overlaps(200, 20, 3); }
TEST(SlowEndProofs, AreRightAboutAMillionEndsPutAtTheGoalByFcl) { expect_overlaps(1000, 1000, 4); }

}  // namespace
}  // namespace modsearch
