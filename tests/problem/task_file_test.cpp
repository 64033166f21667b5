#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <nlohmann/json.hpp>
#include <numbers>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using test::TemporaryFolder;
using ::testing::HasSubstr;

json matrix(double x, double y, double z) { return {{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}, {0, 0, 0, 1}}; }

json reach(const std::string& id, double x) {
  return {{"ID", id}, {"type", "reach"}, {"goalPose", {{"nominal", matrix(x, 0, 1)}}}};
}

json task(std::vector<json> goals) {
  return {{"header", {{"ID", "test"}, {"version", "2022"}, {"timeStepSize", 0.02}, {"gravity", {0, 0, -9.81}}}},
          {"obstacles", json::array()},
          {"constraints", json::array()},
          {"goals", goals}};
}

TaskFile load(const json& text) {
  const TemporaryFolder folder;
  return load_task(folder.write("task.json", text.dump()));
}

std::string refusal(const std::filesystem::path& file) {
  try {
    static_cast<void>(load_task(file));
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

std::vector<std::string> ids(const TaskFile& file) {
  std::vector<std::string> result;
  for (const Goal& goal : file.goals) result.push_back(goal.id);
  return result;
}

class RecordedTask : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(folder_)) GTEST_SKIP() << "no recorded tasks under " << test::shared_folder();
  }
  std::filesystem::path folder_ = test::shared_folder() / "data/timor/tasks";
};

TEST_F(RecordedTask, WithoutGoalsIsNoTaskYetReads) {
  const TaskFile file = load_task(folder_ / "simple/Empty.json");
  EXPECT_EQ(file.task, nullptr);
  EXPECT_TRUE(file.goals.empty());
  EXPECT_EQ(file.time_step, 0.01);
}

TEST_F(RecordedTask, OfTwoPosesReadsWithItsBase) {
  const TaskFile file = load_task(folder_ / "simple/PTP_1.json");
  ASSERT_EQ(file.goals.size(), 2U);
  EXPECT_EQ(file.goals[0].type, GoalType::kAt);
  EXPECT_EQ(file.goals[1].type, GoalType::kReach);
  EXPECT_EQ(file.X_WB.translation(), (Eigen::Vector3d{1.0, 2.0, 3.0}));
  EXPECT_EQ(file.goals[1].position(), (Eigen::Vector3d{2.0, 2.0, 3.0}));
  ASSERT_EQ(file.goals[0].region.tolerances().size(), 2U);
  EXPECT_EQ(file.goals[0].region.tolerances()[0].projection, Projection::kRSph);
  EXPECT_EQ(file.goals[0].region.tolerances()[0].upper, 0.01);
  EXPECT_EQ(file.task->name(), "simple/PTP_1");
}

TEST_F(RecordedTask, WithToleranceFramesMixedReadsEachInItsOwn) {
  const TaskFile file = load_task(folder_ / "simple/PTP_mixed_frames.json");
  ASSERT_EQ(file.goals.size(), 1U);
  const std::vector<Tolerance>& tolerances = file.goals[0].region.tolerances();
  ASSERT_EQ(tolerances.size(), 5U);
  EXPECT_EQ(tolerances[1].projection, Projection::kZ);
  EXPECT_EQ(tolerances[2].projection, Projection::kZ);
  EXPECT_EQ(tolerances[1].R_TN, Eigen::Matrix3d::Identity());
  // The second z is the world's: the rows of R_WN are 0.7071, 0, 0.7071 / -0.7071, 0, 0.7071 / 0, -1, 0.
  Eigen::Matrix3d R_WN;
  R_WN << std::sqrt(0.5), 0.0, std::sqrt(0.5), -std::sqrt(0.5), 0.0, std::sqrt(0.5), 0.0, -1.0, 0.0;
  EXPECT_LT((tolerances[2].R_TN - R_WN).cwiseAbs().maxCoeff(), 1e-8);  // written with nine digits
  ASSERT_EQ(file.scene->obstacles().size(), 1U);
  EXPECT_EQ(std::get<Box>(file.scene->obstacles()[0].shapes[0].shape).size, (Eigen::Vector3d{2.0, 2.0, 0.1}));
}

TEST_F(RecordedTask, AmongMeshesReadsWithTheirTriangles) {
  const TaskFile file = load_task(folder_ / "simple/PTP_3.json");
  EXPECT_EQ(ids(file), (std::vector<std::string>{"1", "2", "3"}));
  ASSERT_EQ(file.scene->obstacles().size(), 1U);
  const auto& mesh = std::get<Mesh>(file.scene->obstacles()[0].shapes[0].shape);
  EXPECT_GT(mesh.triangles->triangles.size(), 100U);
  // Scaled from millimetres: a milling machine is a few metres large.
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.triangles->vertices) box.extend(vertex);
  EXPECT_GT(box.sizes().maxCoeff(), 1.0);
  EXPECT_LT(box.sizes().maxCoeff(), 10.0);
}

TEST_F(RecordedTask, WithAReturnEndsInThePostureItBeganWith) {
  const TaskFile file = load_task(folder_ / "simple/PTP_2_cycle.json");
  EXPECT_EQ(ids(file), (std::vector<std::string>{"1", "2", "3"}));
  ASSERT_EQ(file.task->steps().size(), 4U);
  const TaskStep& last = file.task->steps()[3];
  EXPECT_EQ(last.id, "4");
  EXPECT_EQ(last.kind, TaskStep::Kind::kReturn);
  EXPECT_EQ(last.goal, -1) << "no goal is named: back to the start";
  EXPECT_FALSE(file.task->any_order());
  EXPECT_TRUE(file.task->statics().limited);
}

TEST_F(RecordedTask, WithAPauseKeepsItBehindTheGoalBefore) {
  const TaskFile file = load_task(folder_ / "simple/PTP_pause.json");
  ASSERT_EQ(file.task->steps().size(), 3U);
  EXPECT_EQ(file.task->steps()[2].kind, TaskStep::Kind::kPause);
  EXPECT_EQ(file.task->steps()[2].duration, 0.4);
  EXPECT_EQ(file.goals.size(), 2U);
}

TEST_F(RecordedTask, OfATrajectoryKeepsEveryPoseAndAFewAsGoals) {
  for (const auto& [name, n] : {std::pair{"simple/traj_1.json", 1000U}, std::pair{"simple/traj_window.json", 918U}}) {
    const TaskFile file = load_task(folder_ / name);
    ASSERT_EQ(file.task->steps().size(), 1U);
    const TaskStep& step = file.task->steps()[0];
    EXPECT_EQ(step.kind, TaskStep::Kind::kFollow);
    EXPECT_GE(step.trajectory->poses.size(), n);
    EXPECT_TRUE(step.trajectory->times.empty());
    EXPECT_EQ(file.goals.size(), static_cast<std::size_t>(step.n_goals));
    EXPECT_LE(file.goals.size(), 20U);
    EXPECT_EQ(file.goals.back().position(), step.trajectory->poses.back().nominal().translation());
  }
}

TEST_F(RecordedTask, ThatNeedsMoreIsRefusedByTheNameOfWhatIsMissing) {
  EXPECT_THAT(
      refusal(folder_ / "industrial/drilling_crok_description.json"),
      HasSubstr("at /goals/0/constraints/0/pose: holding the end effector within a pose along the motion is not "
                "supported yet"));
}

TEST(TaskFile, GivesAPoseWithoutTolerancesOneMillimetreAndHalfADegree) {
  const TaskFile file = load(task({reach("1", 1.0)}));
  const PoseRegion& region = file.goals[0].region;
  Eigen::Isometry3d X = region.nominal();
  X.translation().x() += 0.0009;
  EXPECT_TRUE(region.contains(X));
  X.translation().x() += 0.0002;
  EXPECT_FALSE(region.contains(X));
  X = region.nominal();
  X.rotate(Eigen::AngleAxisd{0.49 * std::numbers::pi / 180.0, Eigen::Vector3d::UnitY()});
  EXPECT_TRUE(region.contains(X));
  X.rotate(Eigen::AngleAxisd{0.02 * std::numbers::pi / 180.0, Eigen::Vector3d::UnitY()});
  EXPECT_FALSE(region.contains(X));
  EXPECT_EQ(file.time_step, 0.02);
}

TEST(TaskFile, ReadsEveryProjection) {
  json goal = reach("1", 1.0);
  const std::vector<std::string> names{"x",     "y",       "z",   "r_sph", "r_cyl", "phi_cyl",
                                       "theta", "phi_sph", "N_x", "N_y",   "N_z",   "Theta_R"};
  goal["goalPose"]["toleranceProjection"] = names;
  goal["goalPose"]["tolerance"] = std::vector<std::vector<double>>(names.size(), {-0.5, 0.5});
  const TaskFile file = load(task({goal}));
  ASSERT_EQ(file.goals[0].region.tolerances().size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(name(file.goals[0].region.tolerances()[i].projection), names[i]);
  }
}

TEST(TaskFile, TurnsATolerancesFrameGivenAsAPoseOfTheWorld) {
  json goal = reach("1", 1.0);
  goal["goalPose"]["toleranceProjection"] = {"x"};
  goal["goalPose"]["tolerance"] = {{-0.01, 0.5}};
  // A frame whose x axis is the world's y.
  goal["goalPose"]["toleranceFrame"] = {{0, -1, 0, 9}, {1, 0, 0, 9}, {0, 0, 1, 9}, {0, 0, 0, 1}};
  const PoseRegion region = load(task({goal})).goals[0].region;
  Eigen::Isometry3d X = region.nominal();
  X.translation().y() += 0.4;
  EXPECT_TRUE(region.contains(X));
  X.translation().y() -= 0.8;
  EXPECT_FALSE(region.contains(X));
}

TEST(TaskFile, VisitsNamedGoalsInTheirOrderAndTheOthersWhereTheyStand) {
  json text = task({reach("a", 1.0), reach("b", 1.1), reach("c", 1.2), reach("d", 1.3)});
  text["constraints"] = {{{"type", "allGoalsFulfilledInOrder"}, {"order", {"d", "a", "c"}}}};
  EXPECT_EQ(ids(load(text)), (std::vector<std::string>{"d", "b", "a", "c"}));
}

TEST(TaskFile, LeavesTheOrderFreeWhereOnlyAllGoalsAreAskedFor) {
  json text = task({reach("a", 1.0), reach("b", 1.1)});
  EXPECT_FALSE(load(text).task->any_order()) << "nothing is said: as the file has them";
  text["constraints"] = {{{"type", "allGoalsFulfilled"}}};
  EXPECT_TRUE(load(text).task->any_order());
  text["constraints"].push_back({{"type", "allGoalsFulfilledInOrder"}, {"order", {"b", "a"}}});
  EXPECT_FALSE(load(text).task->any_order());
}

json ball(double x) {
  return {{"nominal", matrix(x, 0, 1)}, {"toleranceProjection", {"r_sph"}}, {"tolerance", {{0.0, 0.001}}}};
}

TEST(TaskFile, ReadsATimedTrajectoryAndWhatComesAfterIt) {
  json text =
      task({{{"ID", "f"}, {"type", "follow"}, {"trajectory", {{"pose", {ball(1.0), ball(1.1)}}, {"t", {0.0, 2.0}}}}},
            {{"ID", "p"}, {"type", "pause"}, {"duration", 0.5}},
            reach("a", 1.2),
            {{"ID", "r"}, {"type", "returnTo"}, {"returnToGoal", "f"}}});
  const TaskFile file = load(text);
  const std::span<const TaskStep> steps = file.task->steps();
  ASSERT_EQ(steps.size(), 4U);
  EXPECT_EQ(steps[0].trajectory->poses.size(), 6U) << "10 cm in steps of 2 cm";
  EXPECT_NEAR(steps[0].trajectory->times[1], 0.4, 1e-12);
  EXPECT_EQ(steps[2].goal, 6);
  EXPECT_EQ(steps[3].goal, 5) << "the end of the trajectory";
  text["goals"][3]["returnToGoal"] = "nobody";
  EXPECT_THROW((void)load(text), FileError);
  text["goals"][3]["returnToGoal"] = "f";
  text["goals"][0]["trajectory"]["t"] = {0.0, 0.0};
  EXPECT_THROW((void)load(text), FileError);
}

TEST(TaskFile, PutsStepsAndTheirGoalsInOrderTogether) {
  json text = task({{{"ID", "f"}, {"type", "follow"}, {"trajectory", {{"pose", {ball(1.0), ball(1.1)}}}}},
                    reach("a", 1.2),
                    {{"ID", "r"}, {"type", "returnTo"}, {"returnToGoal", "a"}}});
  text["constraints"] = {{{"type", "allGoalsFulfilledInOrder"}, {"order", {"a", "f"}}}};
  const TaskFile file = load(text);
  EXPECT_EQ(file.goals[0].id, "a");
  EXPECT_EQ(file.task->steps()[0].id, "a");
  EXPECT_EQ(file.task->steps()[1].goal, 1);
  EXPECT_EQ(file.task->steps()[2].goal, 0);
}

TEST(TaskFile, ReadsWhatTheArmHasToBear) {
  json text = task({reach("a", 1.0)});
  text["header"]["gravity"] = {0, 0, -1.6};
  text["payload"] = 2.5;
  text["goals"][0]["externalForce"] = {1, 2, 3};
  text["goals"][0]["externalTorque"] = {4, 5, 6};
  EXPECT_FALSE(load(text).task->statics().limited);
  text["constraints"] = {{{"type", "joint"}, {"parts", {"q", "tau"}}}};
  const TaskFile file = load(text);
  const StaticLoad load_there = load_at(*file.task, 0);
  EXPECT_TRUE(file.task->statics().limited);
  EXPECT_EQ(load_there.gravity, (Eigen::Vector3d{0, 0, -1.6}));
  EXPECT_EQ(load_there.payload, 2.5);
  EXPECT_EQ(load_there.wrench.force, (Eigen::Vector3d{1, 2, 3}));
  EXPECT_EQ(load_there.wrench.torque, (Eigen::Vector3d{4, 5, 6}));
  text["payload"] = -1.0;
  EXPECT_THROW((void)load(text), FileError);
}

TEST(TaskFile, ReadsWhereTheBaseMayStand) {
  json text = task({reach("a", 1.0)});
  json pose = {{"nominal", matrix(1, 2, 0)},
               {"toleranceProjection", {"x", "y", "N_z"}},
               {"tolerance", {{-0.5, 0.5}, {0.0, 0.25}, {-1.0, 1.0}}}};
  text["constraints"] = {{{"type", "basePlacement"}, {"pose", pose}}};
  const TaskFile file = load(text);
  ASSERT_TRUE(file.base.has_value());
  EXPECT_EQ(file.X_WB.translation(), (Eigen::Vector3d{1, 2, 0}));
  EXPECT_EQ(file.base->x.lower, -0.5);
  EXPECT_EQ(file.base->y.upper, 0.25);
  EXPECT_EQ(file.base->z.upper, 0.0);
  EXPECT_EQ(file.base->yaw.upper, 1.0);
  text["constraints"][0]["pose"]["toleranceProjection"][0] = "r_cyl";
  EXPECT_THROW((void)load(text), FileError);
}

TEST(TaskFile, ReadsHowAnObstacleMoves) {
  json text = task({reach("a", 1.0)});
  const json geometry = {{"type", "sphere"}, {"parameters", {{"r", 0.1}}}, {"pose", matrix(1, 0, 0)}};
  text["obstacles"] = {{{"ID", "1"},
                        {"collision", {geometry}},
                        {"motion", {{"t", {0.0, 2.0}}, {"pose", {matrix(0, 0, 0), matrix(0, 1, 0)}}}}}};
  const TaskFile file = load(text);
  EXPECT_TRUE(file.scene->any_moves());
  const Obstacle& obstacle = file.scene->obstacles()[0];
  EXPECT_EQ((obstacle.motion.at(1.0) * obstacle.shapes[0].X_FG).translation(), (Eigen::Vector3d{1.0, 0.5, 0.0}));
  text["obstacles"][0]["motion"]["t"] = {2.0, 0.0};
  EXPECT_THROW((void)load(text), FileError);
}

TEST(TaskFile, KeepsHome) {
  json text = task({reach("a", 1.0)});
  text["home"] = {0.1, -0.2};
  EXPECT_EQ(load(text).task->home(), (Eigen::Vector2d{0.1, -0.2}));
}

TEST(TaskFile, DoesNotApplyTheRepeatedPoseOfAnObstacleAgain) {
  json text = task({reach("a", 1.0)});
  const json geometry = {{"type", "sphere"}, {"parameters", {{"r", 0.1}}}, {"pose", matrix(1, 2, 3)}};
  text["obstacles"] = {{{"ID", "1"}, {"pose", matrix(1, 2, 3)}, {"collision", {geometry}}},
                       {{"ID", "2"}, {"pose", {{"nominal", matrix(1, 2, 3)}}}, {"collision", geometry}}};
  const TaskFile file = load(text);
  for (const Obstacle& obstacle : file.scene->obstacles()) {
    EXPECT_EQ(obstacle.shapes[0].X_FG.translation(), (Eigen::Vector3d{1.0, 2.0, 3.0}));
  }
}

TEST(TaskFile, AcceptsTheConstraintsThatTheProblemDecides) {
  json text = task({reach("a", 1.0)});
  text["constraints"] = {{{"type", "joint"}, {"parts", {"q", "dq", "dq", "ddq", "tau"}}},
                         {{"type", "selfCollisionFree"}},
                         {{"type", "collisionFree"}},
                         {{"type", "allGoalsFulfilled"}},
                         {{"type", "validAssembly"}}};
  text["goals"][0]["constraints"] = json::array();
  text["objects"] = json::array();
  EXPECT_EQ(load(text).goals.size(), 1U);
}

/// A task with a base in `pose`.
TaskFile with_base(const json& pose) {
  json text = task({reach("a", 1.0)});
  text["constraints"] = {{{"type", "basePlacement"}, {"pose", pose}}};
  return load(text);
}

constexpr double kHalfDegree = std::numbers::pi / 360.0;

// CoBRA: what is not listed is free. A list of x, y and z alone says nothing of the rotation.
TEST(BaseOfTask, IsFreeToTurnWhereItsTolerancesSayNothingOfTurning) {
  const TaskFile file = with_base({{"nominal", matrix(0, 0, 0)},
                                   {"toleranceProjection", {"x", "y", "z"}},
                                   {"tolerance", {{-1.0, 1.0}, {-1.0, 1.0}, {-0.001, 0.001}}},
                                   {"frame", {"nominal", "nominal", "nominal"}}});
  ASSERT_TRUE(file.base.has_value());
  EXPECT_EQ(file.base->x.lower, -1.0);
  EXPECT_EQ(file.base->y.upper, 1.0);
  EXPECT_EQ(file.base->z.upper, 0.0) << "a millimetre is how exactly it is mounted";
  EXPECT_EQ(file.base->yaw.lower, -std::numbers::pi);
  EXPECT_EQ(file.base->yaw.upper, std::numbers::pi);
}

TEST(BaseOfTask, WithinTheDefaultToleranceIsFixed) {
  const TaskFile file =
      with_base({{"nominal", matrix(1, 2, 0)},
                 {"toleranceProjection", {"x", "y", "z", "Theta_R"}},
                 {"tolerance", {{-0.001, 0.001}, {-0.001, 0.001}, {-0.001, 0.001}, {0.0, kHalfDegree}}}});
  EXPECT_FALSE(file.base.has_value());
  EXPECT_EQ(file.X_WB.translation(), (Eigen::Vector3d{1, 2, 0}));
  const TaskFile ball = with_base({{"nominal", matrix(1, 2, 0)},
                                   {"toleranceProjection", {"r_sph", "N_z"}},
                                   {"tolerance", {{0.0, 0.001}, {-kHalfDegree, kHalfDegree}}}});
  EXPECT_FALSE(ball.base.has_value());
}

TEST(BaseOfTask, TurnsAsFarAsAllOfItsTolerancesLeave) {
  const TaskFile file = with_base({{"nominal", matrix(0, 0, 0)},
                                   {"toleranceProjection", {"N_z", "Theta_R"}},
                                   {"tolerance", {{-0.2, 2.0}, {0.0, 0.5}}}});
  ASSERT_TRUE(file.base.has_value());
  EXPECT_EQ(file.base->yaw.lower, -0.2);
  EXPECT_EQ(file.base->yaw.upper, 0.5);
}

// With R_WN = Rz(90 degrees), x of the nominal frame is y of the world: 0.5 m along it from (1, 2, 0) is (1, 2.5, 0).
TEST(BaseOfTask, StandsWhereIntervalsWithoutWidthPutIt) {
  const TaskFile file = with_base({{"nominal", {{0, -1, 0, 1}, {1, 0, 0, 2}, {0, 0, 1, 0}, {0, 0, 0, 1}}},
                                   {"toleranceProjection", {"x", "Theta_R"}},
                                   {"tolerance", {{0.5, 0.5}, {0.0, 0.0}}}});
  EXPECT_FALSE(file.base.has_value());
  EXPECT_LT((file.X_WB.translation() - Eigen::Vector3d{1.0, 2.5, 0.0}).norm(), 1e-15);
}

TEST(BaseOfTask, InABallIsRefusedByName) {
  const json pose = {{"nominal", matrix(0, 0, 0)},
                     {"toleranceProjection", json::array({"r_sph"})},
                     {"tolerance", json::array({{0.0, 0.5}})}};
  try {
    static_cast<void>(with_base(pose));
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("not yet in a cylinder or a ball"));
  }
}

/// What Timor 1.1.1 writes: names that are null, frames, the frame of a tolerance under another name, constraints that
/// always hold as empty objects, ends that are infinite.
json task_as_timor_writes_it() {
  json text = task({reach("a", 1.0)});
  text["header"]["author"] = {"A"};
  text["header"]["date"] = "2026-01-31";
  text["header"]["taskName"] = nullptr;
  text["frames"] = json::object();
  const json geometry = {{"type", "sphere"}, {"parameters", {{"r", 0.1}}}, {"pose", matrix(1, 2, 3)}};
  text["obstacles"] = {{{"ID", "ball"}, {"name", nullptr}, {"collision", {geometry}}}};
  text["constraints"] = {json::object(), {{"type", "alwaysTrue"}}};
  text["goals"][0]["constraints"] = json::array();
  text["goals"][0]["goalPose"] = {{"nominal", matrix(1, 0, 1)},
                                  {"toleranceProjection", {"x", "y"}},
                                  {"tolerance", {{-0.5, 0.5}, {0, 0.25}}},
                                  {"frame", {"world", "nominal"}}};
  return text;
}

TEST(TaskFile, ReadsWhatTimorWritesToday) {
  const TaskFile file = load(task_as_timor_writes_it());
  EXPECT_EQ(file.scene->obstacles()[0].name, "ball") << "a name that nobody gave is the ID";
  ASSERT_EQ(file.goals[0].region.tolerances().size(), 2U);
  EXPECT_EQ(file.goals[0].region.tolerances()[1].upper, 0.25);
}

// Timor takes any pose where the lists of tolerances are empty, and writes a base so that came without any.
TEST(TaskFile, TakesEmptyListsOfAGoalForAnyPoseAndOfABaseForAFixedOne) {
  json pose = {{"nominal", matrix(1, 0, 1)},
               {"toleranceProjection", json::array()},
               {"tolerance", json::array()},
               {"toleranceFrame", json::array()}};
  json text = task({reach("a", 1.0)});
  text["goals"][0]["goalPose"] = pose;
  EXPECT_TRUE(load(text).goals[0].region.tolerances().empty());
  EXPECT_FALSE(with_base(pose).base.has_value());
}

TEST(TaskFile, LeavesOutTolerancesFromEndToEnd) {
  std::string text = task_as_timor_writes_it().dump();
  text.replace(text.find("[-0.5,0.5]"), 10, "[-Infinity,Infinity]");
  const TemporaryFolder folder;
  const TaskFile file = load_task(folder.write("task.json", text));
  ASSERT_EQ(file.goals[0].region.tolerances().size(), 1U);
  EXPECT_EQ(file.goals[0].region.tolerances()[0].projection, Projection::kY);
  text.replace(text.find("[-Infinity,Infinity]"), 20, "[0,Infinity]");
  EXPECT_THAT(refusal(folder.write("half.json", text)),
              HasSubstr("at /goals/0/goalPose/tolerance/0/1: Infinity is not a finite end, as the other one is"));
}

// world -> table: 2 m along y. table -> vice: Rz(90 degrees) and 1 m along x. A goal at x = 0.5 of the vice, whose x is
// the world's y, lies at (1, 2.5, 0).
json task_with_frames() {
  json text = task({reach("a", 0.0)});
  text["frames"] = {
      {"vice", {{"parent", "table"}, {"transformation", {{0, -1, 0, 1}, {1, 0, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}}},
      {"table", {{"parent", "world"}, {"transformation", matrix(0, 2, 0)}}}};
  text["goals"][0]["goalPose"] = {{"nominal", matrix(0.5, 0, 0)}, {"nominalParent", "vice"}};
  return text;
}

TEST(TaskFrames, CarryPosesThatHangOnThem) {
  EXPECT_LT((load(task_with_frames()).goals[0].position() - Eigen::Vector3d{1.0, 2.5, 0.0}).norm(), 1e-15);
}

// The vice's x is the world's y, so the first row of R_TN, x of the tolerance in terms of the nominal frame (the
// world's axes here), is (0, 1, 0).
TEST(TaskFrames, GiveTolerancesTheirAxes) {
  json text = task_with_frames();
  text["goals"][0]["goalPose"] = {{"nominal", matrix(1, 0, 1)},
                                  {"toleranceProjection", json::array({"x"})},
                                  {"tolerance", json::array({{-0.1, 0.1}})},
                                  {"toleranceFrame", {"vice"}}};
  const Tolerance tolerance = load(text).goals[0].region.tolerances()[0];
  EXPECT_LT((tolerance.R_TN.row(0).transpose() - Eigen::Vector3d::UnitY()).norm(), 1e-15);
}

TEST(TaskFrames, OfGoalsAreTheirNominalPoses) {
  json text = task_with_frames();
  text["goals"].push_back(reach("b", 0.25));
  text["goals"][1]["goalPose"]["nominalParent"] = "goal.a";
  // 0.25 m along x and 1 m along z of the first goal, whose x is the world's y.
  EXPECT_LT((load(text).goals[1].position() - Eigen::Vector3d{1.0, 2.75, 1.0}).norm(), 1e-15);
}

// The vice is turned by 90 degrees: a force along its x acts along the world's y.
TEST(TaskFrames, TurnTheLoadsThatAreGivenInThem) {
  json text = task_with_frames();
  text["goals"][0]["externalForce"] = {5, 0, 0};
  text["goals"][0]["forceTorqueReferenceFrame"] = "vice";
  EXPECT_LT((load_at(*load(text).task, 0).wrench.force - Eigen::Vector3d{0, 5, 0}).norm(), 1e-15);
}

TEST(TaskFrames, ThatHangOnNothingAreRefusedByName) {
  const TemporaryFolder folder;
  const auto refused = [&](const char* pointer, const json& value) {
    json text = task_with_frames();
    text[json::json_pointer{pointer}] = value;
    return refusal(folder.write("task.json", text.dump()));
  };
  EXPECT_THAT(refused("/frames/table/parent", "shelf"),
              HasSubstr("at /frames/table/parent: \"shelf\" is not the name of a frame"));
  EXPECT_THAT(refused("/frames/table/parent", "vice"), HasSubstr("it hangs on itself"));
  EXPECT_THAT(refused("/goals/0/goalPose/nominalParent", "lathe"),
              HasSubstr("\"lathe\" is not the name of a frame (known here: table, vice, world)"));
  EXPECT_THAT(refused("/frames/world", {{"parent", "table"}}), HasSubstr("the frame \"world\" is there already"));
  EXPECT_THAT(refused("/frames/a.b", {{"parent", "table"}}), HasSubstr("has a dot"));
}

TEST(EndEffectorConstraint, ThatLimitsNothingIsReadAndOthersAreRefusedForWhatTheyMean) {
  const TemporaryFolder folder;
  const auto refused = [&](const json& constraint) {
    json text = task({reach("a", 1.0)});
    text["constraints"] = json::array({constraint});
    return refusal(folder.write("task.json", text.dump()));
  };
  EXPECT_EQ(refused({{"type", "endEffector"}, {"v_min", 0.0}}), "");
  EXPECT_THAT(refused({{"type", "endEffector"}, {"v_max", 0.3}}),
              HasSubstr("at /constraints/0/v_max: a limit of the end effector's speed along the motion"));
  EXPECT_THAT(refused({{"type", "endEffector"}, {"o_max", 0.3}}), HasSubstr("rate of turn"));
  EXPECT_THAT(refused({{"type", "endEffector"}, {"pose", {{"nominal", matrix(0, 0, 0)}}}}),
              HasSubstr("holding the end effector within a pose along the motion"));
  EXPECT_EQ(refused({{"type", "goalsBySameRobot"}, {"goals", {"a"}}}), "") << "there is one robot";
}

TEST(TaskFile, TakesTheTimesOfATrajectoryAsAStepToo) {
  json text = task({reach("a", 1.0)});
  const json pose = {{"nominal", matrix(1, 0, 1)}};
  text["goals"] = {{{"ID", "f"}, {"type", "follow"}, {"trajectory", {{"t", 0.5}, {"pose", {pose, pose, pose}}}}}};
  EXPECT_EQ(load(text).task->steps()[0].trajectory->times.back(), 1.0);
}

}  // namespace
}  // namespace modsearch
