#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/problem/files.hpp>
#include <numbers>

namespace modsearch {
namespace {

constexpr double kPi = std::numbers::pi;

// Two joints about the z axis, a body with `shape` at (0.3, 0, 0.5) between them if `off_axis`, else on the axis, and a
// tip at (0.5, 0, 1) that moves with the second.
Chain coaxial_pair(const AffineShape& shape, bool off_axis) {
  const auto at = [](double x, double y, double z) { return Eigen::Isometry3d{Eigen::Translation3d{x, y, z}}; };
  const Joint joint{.name = "turn", .lower = -kPi, .upper = kPi};
  ChainBuilder builder{0};
  builder.joint(joint);
  builder.body("between", 0, 1.0, {{shape, at(off_axis ? 0.3 : 0.0, 0.0, 0.5)}});
  builder.move(at(0.0, 0.0, 1.0)).joint(joint).move(at(0.5, 0.0, 0.0));
  return builder.build();
}

// An obstacle 0.1 m in radius at (0.3, 0, 0.5), where the body stands at q = 0, and a goal for the tip.
Attempt attempt(const Chain& chain) {
  const Scene scene{{{"ball", {{Sphere{0.1}, Eigen::Isometry3d{Eigen::Translation3d{0.3, 0.0, 0.5}}}}}}};
  const GoalTask task{"t", {{"1", GoalType::kReach, PoseRegion::ball({0.5, 0.0, 1.0}, 1e-3)}}};
  return task.attempt(chain.at(Eigen::VectorXd{0}), scene, AttemptOptions{});  // level posture
}

// The tip is at the goal wherever the first joint stands if the second turns back: the body goes to the far side, 0.6 m
// from the obstacle's centre (256 samples: within 0.6 (1 - cos(pi / 256)) < 0.1 mm).
TEST(Attempt, TurnsABodyBetweenTwoCoaxialJointsOutOfTheWay) {
  const AffineShape ball{AffineShape::Kind::kSphere, {0.05}, nullptr};
  const Attempt result = attempt(coaxial_pair(ball, true));
  EXPECT_TRUE(result.achieved);
  EXPECT_NEAR(result.clearance, 0.6 - 0.15, 1e-4);
  EXPECT_GT(result.work.forward, 200);
}

// A box on the axis shows its corners, a cylinder nothing: one posture is enough to say how far it is away.
TEST(Attempt, LooksAtOnePostureWhereTurnsBetweenCoaxialJointsDoNotShow) {
  const AffineShape box{AffineShape::Kind::kBox, {0.2, 0.2, 0.2}, nullptr};
  const Attempt boxed = attempt(coaxial_pair(box, false));
  EXPECT_NEAR(boxed.clearance, 0.3 - 0.1 - 0.1, 1e-4);  // a face towards the obstacle, not an edge
  EXPECT_GT(boxed.work.forward, 200);

  const AffineShape cylinder{AffineShape::Kind::kCylinder, {0.1, 0.2}, nullptr};
  const Attempt round = attempt(coaxial_pair(cylinder, false));
  EXPECT_NEAR(round.clearance, 0.3 - 0.1 - 0.1, 1e-9);
  EXPECT_LE(round.work.forward, 2);
}

// seed/random_obstacles: the only turn that a link or a rotary can make without moving the tip is one that nobody sees.
TEST(Attempt, LooksAtOnePostureOfEveryOneModuleDesignThatIsNoHinge) {
  const ProblemFile file = load_problem_file("seed/random_obstacles");
  Rng rng{1};
  for (std::uint64_t i = 0; i < 100; ++i) {
    const auto problem = file.instance({1, i});
    for (const char* name : {"link", "rotary"}) {
      const int k = problem->library().find(name).value();
      Parameters lengths(problem->library().type(k).n_parameters());
      for (double& length : lengths) length = rng.uniform(0.5, 1.5);
      EXPECT_LE(problem->evaluate({{{k, lengths}}}).attempt.work.forward, 2);
    }
  }
}

// What overlaps costs points even where the goal is missed; how much room there is matters to nobody then.
TEST(Attempt, ThatMissesSaysWhetherItCollidesAndMeasuresNothing) {
  const AffineShape ball{AffineShape::Kind::kSphere, {0.05}, nullptr};
  const Chain chain = coaxial_pair(ball, true);  // the body stands anywhere on a circle of 0.3 m about the axis
  const GoalTask task{"t", {{"1", GoalType::kReach, PoseRegion::ball({0.5, 0.0, 2.0}, 1e-3)}}};
  const auto missed = [&](double radius) {
    const Scene scene{{{"ball", {{Sphere{radius}, Eigen::Isometry3d{Eigen::Translation3d{0.3, 0.0, 0.5}}}}}}};
    return task.attempt(chain.at(Eigen::VectorXd{0}), scene, AttemptOptions{});
  };
  const Attempt free = missed(0.1);  // the far side is 0.6 m away
  EXPECT_FALSE(free.reached);
  EXPECT_FALSE(free.collides);
  EXPECT_EQ(free.clearance, std::numeric_limits<double>::infinity());
  const Attempt inside = missed(0.7);
  EXPECT_TRUE(inside.collides);
  EXPECT_EQ(inside.why, Failure::kProvedInfeasible);  // 2 m up, the arm ends 1 m up
  EXPECT_EQ(inside.clearance, std::numeric_limits<double>::infinity());
  // Nor where another goal is reached.
  const GoalTask two{"t", {task.goals()[0], {"2", GoalType::kReach, PoseRegion::ball({0.5, 0.0, 1.0}, 1e-3)}}};
  const Scene scene{{{"ball", {{Sphere{0.1}, Eigen::Isometry3d{Eigen::Translation3d{0.3, 0.0, 0.5}}}}}}};
  const Attempt half = two.attempt(chain.at(Eigen::VectorXd{0}), scene, AttemptOptions{});
  EXPECT_FALSE(half.collides);
  EXPECT_EQ(half.clearance, std::numeric_limits<double>::infinity());
}

// A target on the base's axis: the rotary's elbow may point anywhere, and that shows.
TEST(Attempt, StillTurnsTheElbowWhereTheTargetIsOnTheAxis) {
  RobotProblemSpec spec = load_problem_file("seed/random_obstacles").spec;
  spec.task = std::make_shared<GoalTask>(
      "above", std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::ball({0.0, 0.0, 1.5}, 1.2)}});
  const RobotProblem problem{spec};  // the tip is 0.645 m beside the axis, 0.845 m below: 1.06 m away all round
  const int k = problem.library().find("rotary").value();
  const Design design{{{k, Parameters{{0.6, 0.7}}}}};
  const Evaluation evaluation = problem.evaluate(design);
  const std::shared_ptr<const Chain> chain = problem.chain(design.types());
  const Arm arm = chain->at(design.parameters());
  double best = -1.0;  // by brute force over the joint that shows
  for (int i = 0; i < 2000; ++i) {
    Work work;
    const Eigen::Vector2d q{0.0, -kPi + 2.0 * kPi * i / 2000};
    best = std::max(best, problem.scene().clearance(arm, arm.forward(q), work));
  }
  EXPECT_NEAR(evaluation.attempt.clearance, best, 0.05);  // 16 samples all round
  EXPECT_LE(evaluation.attempt.clearance, best + 1e-4);
}

}  // namespace
}  // namespace modsearch
