#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/study/solution_page.hpp>

namespace modsearch {
namespace {

using ::testing::StartsWith;

Goal point(const std::string& id, const Eigen::Vector3d& p_W) {
  return {id, GoalType::kReach, PoseRegion::ball(p_W, 1e-3)};
}

struct Shown {
  Page page;
  Evaluation evaluation;
};

// The page of a design of one module of library `seed`.
Shown shown(const std::vector<Goal>& goals, std::vector<Obstacle> obstacles, const std::string& type,
            const Parameters& lengths) {
  RobotProblemSpec spec;
  spec.name = "test";
  spec.library = load_library("seed");
  spec.task = std::make_shared<GoalTask>("t", goals);
  spec.scene = std::make_shared<Scene>(std::move(obstacles));
  const RobotProblem problem{spec};
  SolutionRecord record;
  record.problem = "test";
  record.design = {{{problem.library().find(type).value(), lengths}}};
  record.evaluation = problem.evaluate(record.design);
  return {page_of_solution(problem, record, {}), record.evaluation};
}

TEST(PageOfSolution, MarksWhatTouchesAndSaysSoBesideTheGoal) {
  const Obstacle ball{"ball", {{Sphere{0.1}, Eigen::Isometry3d{Eigen::Translation3d{0.1, 0, 0.5}}}}};
  const Page page = shown({point("1", {0, 0, 1})}, {ball}, "link", Parameters{{1.0}}).page;
  ASSERT_EQ(page.touches.size(), 1U);
  const PageTouch& touch = page.touches[0];
  EXPECT_EQ(page.bodies[static_cast<std::size_t>(touch.body)].name, "1.link.link");
  EXPECT_TRUE(touch.obstacle);
  EXPECT_EQ(touch.other, 0);
  EXPECT_NEAR(touch.depth, 0.055, 1e-9);         // 0.1 m and 0.055 m around axes 0.1 m apart
  EXPECT_NEAR(touch.position[0], 0.0275, 1e-6);  // between the link's side at 0.055 m and the ball's at 0
  EXPECT_EQ(page.targets[0].miss, "link (module 1) is 55 mm deep in obstacle ball");
}

// A hinge of 1 m and 1 m reaches the first goal and not the second; that one is where it is shown.
TEST(PageOfSolution, ShowsThePostureOfTheGoalThatIsMissed) {
  const Shown seen = shown({point("a", {1, 0, 1}), point("b", {0, 1.5, 1})}, {}, "hinge", Parameters{{1.0, 1.0}});
  EXPECT_EQ(seen.page.targets[0].miss, "");
  EXPECT_THAT(seen.page.targets[1].miss, StartsWith("499 mm outside its tolerance"));
  // The distal link lies along +y there: its body's frame is that of its joint, 1 m above the base.
  const Shown first = shown({point("a", {1, 0, 1})}, {}, "hinge", Parameters{{1.0, 1.0}});
  EXPECT_NE(seen.page.bodies.back().keyframes, first.page.bodies.back().keyframes);
  EXPECT_TRUE(seen.page.touches.empty());
}

TEST(PageOfSolution, MissesNothingWhereTheTaskIsAchieved) {
  const Page page = shown({point("a", {1, 0, 1})}, {}, "hinge", Parameters{{1.0, 1.0}}).page;
  EXPECT_TRUE(page.achieved);
  EXPECT_EQ(page.targets[0].miss, "");
  EXPECT_TRUE(page.touches.empty());
}

}  // namespace
}  // namespace modsearch
