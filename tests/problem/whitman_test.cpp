#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <modsearch/kinematics/separation.hpp>
#include <modsearch/problem/problem_source.hpp>
#include <modsearch/problem/whitman.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

json task(int goals, int boxes, std::uint64_t seed, std::uint64_t index) {
  return json::parse(whitman_task({.goals = goals, .boxes = boxes}, {.seed = seed, .index = index}));
}

Eigen::Vector3d position(const json& pose) {
  return {pose[0][3].get<double>(), pose[1][3].get<double>(), pose[2][3].get<double>()};
}

std::vector<Eigen::Vector3d> boxes_of(const json& given) {
  std::vector<Eigen::Vector3d> boxes;
  for (const json& obstacle : given["obstacles"]) boxes.push_back(position(obstacle["collision"][0]["pose"]));
  return boxes;
}

std::vector<json> goals_of(const json& given) {
  std::vector<json> poses;
  for (const json& goal : given["goals"]) poses.push_back(goal["goalPose"]["nominal"]);
  return poses;
}

/// Distance of a point from a box of 0.25 m; 0 inside.
double distance(const Eigen::Vector3d& p_W, const Eigen::Vector3d& box) {
  return ((p_W - box).cwiseAbs() - Eigen::Vector3d::Constant(0.125)).cwiseMax(0.0).norm();
}

TEST(Whitman, IsTheSameForTheSameSeedAndIndexAndOtherwiseAnother) {
  EXPECT_EQ(whitman_task({}, {.seed = 3, .index = 7}), whitman_task({}, {.seed = 3, .index = 7}));
  std::set<std::string> different;
  for (std::uint64_t i = 0; i < 100; ++i) {
    json each = task(3, 3, 3, i);
    each.erase("header");
    different.insert(each.dump());
  }
  EXPECT_EQ(different.size(), 100U);
  EXPECT_NE(goals_of(task(3, 3, 3, 0)), goals_of(task(3, 3, 4, 0)));
}

TEST(Whitman, HasAsManyGoalsAndBoxesAsAskedWithinTheStatedTolerances) {
  for (const auto& [goals, boxes] : {std::pair{3, 3}, std::pair{5, 5}}) {
    const json given = task(goals, boxes, 0, 0);
    ASSERT_EQ(given["goals"].size(), static_cast<std::size_t>(goals));
    ASSERT_EQ(given["obstacles"].size(), static_cast<std::size_t>(boxes));
    const json& pose = given["goals"][0]["goalPose"];
    EXPECT_EQ(pose["toleranceProjection"], (json{"x", "y", "z", "Theta_R"}));
    EXPECT_EQ(pose["tolerance"][2], (json{-0.001, 0.001}));
    EXPECT_NEAR(pose["tolerance"][3][1].get<double>(), 0.5 * 3.141592653589793 / 180.0, 1e-15);
    EXPECT_EQ(given["constraints"][0]["parts"], (json{"q", "tau"}));
  }
}

TEST(Whitman, PutsDistinctBoxesOnTheGridAwayFromTheBase) {
  std::set<std::tuple<double, double, double>> seen;
  for (std::uint64_t i = 0; i < 200; ++i) {
    std::set<std::tuple<double, double, double>> own;
    for (const Eigen::Vector3d& box : boxes_of(task(5, 5, 1, i))) {
      EXPECT_EQ(box * 4.0, (box * 4.0).array().round().matrix());
      EXPECT_LE(box.head<2>().cwiseAbs().maxCoeff(), 0.5);
      EXPECT_GE(box.z(), 0.0);
      EXPECT_LE(box.z(), 1.0);
      EXPECT_FALSE(std::abs(box.x()) + std::abs(box.y()) < 0.3 && box.z() < 0.5);
      own.insert({box.x(), box.y(), box.z()});
    }
    EXPECT_EQ(own.size(), 5U);
    seen.insert(own.begin(), own.end());
  }
  // 5 x 5 x 5 points without 5 x 2. 1000 draws of 115 alike leave one out with probability below 0.02.
  EXPECT_GE(seen.size(), 113U);
}

TEST(Whitman, DrawsGoalsEvenlyFromTheUnitCubeAndOrientationsFromAllRotations) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotations = Eigen::Matrix3d::Zero();
  double largest_turn = 0.0;
  int n = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const json given = task(3, 3, 2, i);
    const std::vector<Eigen::Vector3d> boxes = boxes_of(given);
    for (const json& pose : goals_of(given)) {
      const Eigen::Vector3d p_W = position(pose);
      EXPECT_LE(p_W.head<2>().cwiseAbs().maxCoeff(), 0.5);
      EXPECT_TRUE(p_W.z() >= 0.0 && p_W.z() <= 1.0);
      EXPECT_FALSE(p_W.head<2>().norm() < 0.2 && p_W.z() < 0.5);
      for (const Eigen::Vector3d& box : boxes) EXPECT_GE(distance(p_W, box), 0.06 - 1e-12);
      const Eigen::Vector3d centred = p_W - Eigen::Vector3d{0.0, 0.0, 0.5};
      sum += centred;
      squares += centred.cwiseAbs2();
      Eigen::Matrix3d R;
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) R(r, c) = pose[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
      }
      EXPECT_LE((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-12);
      rotations += R;
      largest_turn = std::max(largest_turn, std::acos(std::clamp((R.trace() - 1.0) / 2.0, -1.0, 1.0)));
      ++n;
    }
  }
  // Uniform in an interval of length 1 has variance 1/12 and, over 3000 draws, a mean within 0.027 in five standard
  // deviations; the kept-free parts push the rest outwards a little.
  EXPECT_LE((sum / n).head<2>().cwiseAbs().maxCoeff(), 0.027);
  EXPECT_NEAR(squares.x() / n, 1.0 / 12.0, 0.015);
  EXPECT_NEAR(squares.y() / n, 1.0 / 12.0, 0.015);
  EXPECT_NEAR(squares.z() / n, 1.0 / 12.0, 0.015);
  // The mean of uniform rotations is 0, each entry of variance 1/3.
  EXPECT_LE((rotations / n).cwiseAbs().maxCoeff(), 5.0 * std::sqrt(1.0 / 3.0 / n));
  EXPECT_GT(largest_turn, 3.1);
}

TEST(Whitman, InstancesOfTheBuiltInFamiliesAreTheGeneratedTasks) {
  for (const auto& [id, n] : {std::pair{"whitman/3g_3o", 3}, std::pair{"whitman/5g_5o", 5}}) {
    const ProblemFile file = load_problem_file(id);
    EXPECT_TRUE(file.sampled());
    const Instance instance{.seed = 4, .index = 9};
    const auto problem = file.instance(instance);
    EXPECT_EQ(problem->library().name(), "workshop");
    ASSERT_EQ(problem->task().goals().size(), static_cast<std::size_t>(n));
    ASSERT_EQ(problem->scene().obstacles().size(), static_cast<std::size_t>(n));
    const json given = task(n, n, 4, 9);
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      EXPECT_EQ(problem->task().goals()[at].position(), position(goals_of(given)[at]));
      EXPECT_EQ(problem->scene().obstacles()[at].shapes[0].X_FG.translation(), boxes_of(given)[at]);
    }
    EXPECT_EQ(problem->task().name(), "whitman/" + std::to_string(n) + "g_" + std::to_string(n) + "o/4/9");
  }
}

/// Of a gripper alone, held at the nominal pose of a goal: of an arm of base, adapter and gripper its shapes are the
/// last.
double gripper_clearance(const RobotProblem& problem, const Goal& goal, const std::string& size) {
  const ModuleLibrary& library = problem.library();
  std::vector<int> types;
  if (size != "120") types.push_back(library.find("adapter_120_" + size).value());
  types.push_back(library.find("gripper_" + size).value());
  const Chain chain = library.assemble(types);
  const Arm arm = chain.at(Eigen::VectorXd{});
  const Posture posture = arm.forward(Eigen::VectorXd{});
  double clearance = std::numeric_limits<double>::infinity();
  for (const ArmGeometry& geometry : arm.geometries()) {
    const int module = chain.bodies()[static_cast<std::size_t>(geometry.body)].module;
    if (module + 1 < static_cast<int>(types.size())) continue;
    const Eigen::Isometry3d X_WG = goal.region.nominal() * posture.tip.inverse() * geometry.X_FG;
    for (const Obstacle& box : problem.scene().obstacles()) {
      const PlacedShape& shape = box.shapes[0];
      clearance = std::min(clearance, signed_distance(geometry.shape, X_WG, shape.shape, shape.X_FG));
    }
  }
  return clearance;
}

double best_clearance(const RobotProblem& problem, const Goal& goal) {
  double best = -std::numeric_limits<double>::infinity();
  for (const char* size : {"60", "90", "120"}) best = std::max(best, gripper_clearance(problem, goal, size));
  return best;
}

TEST(Whitman, DrawsGoalsAgainUntilSomeEndEffectorIsFreeOfTheBoxes) {
  constexpr double kFree = 0.005;
  const ProblemFile as_drawn = load_problem_file("whitman/5g_5o");
  const ProblemFile with_free_ends = load_problem_file("whitman/5g_5o_free");
  int drawn_again = 0;
  for (std::uint64_t i = 0; i < 100; ++i) {
    const auto before = as_drawn.instance({.seed = 0, .index = i});
    const auto after = with_free_ends.instance({.seed = 0, .index = i});
    EXPECT_EQ(after->task().name(), "whitman/5g_5o_free/0/" + std::to_string(i));
    bool same = true;  // up to the first goal that is not free
    for (std::size_t g = 0; g < 5; ++g) {
      EXPECT_EQ(before->scene().obstacles()[g].shapes[0].X_FG.matrix(),
                after->scene().obstacles()[g].shapes[0].X_FG.matrix());
      const Goal& goal = after->task().goals()[g];
      EXPECT_GE(best_clearance(*after, goal), kFree) << i << ", goal " << g;
      same = same && best_clearance(*before, before->task().goals()[g]) >= kFree;
      if (same) {
        EXPECT_EQ(before->task().goals()[g].position(), goal.position());
      }
    }
    drawn_again += same ? 0 : 1;
  }
  EXPECT_GT(drawn_again, 10);
}

// The tolerance carries no point of a gripper by more than 3.7 mm: sqrt(3) mm and half a degree of 0.22 m.
TEST(Whitman, IsProvedInfeasibleWhereEveryGripperIsDeepInABox) {
  constexpr double kDeep = -0.004;
  for (const auto& [id, least] : {std::pair{"whitman/3g_3o", 5}, std::pair{"whitman/5g_5o", 15}}) {
    const ProblemFile family = load_problem_file(id);
    int deep = 0;
    for (std::uint64_t i = 0; i < 100; ++i) {
      const auto problem = family.instance({.seed = 0, .index = i});
      const std::span<const Goal> goals = problem->task().goals();
      if (std::none_of(goals.begin(), goals.end(),
                       [&](const Goal& goal) { return best_clearance(*problem, goal) < kDeep; })) {
        continue;
      }
      ++deep;
      EXPECT_TRUE(problem->infeasible()) << id << " " << i;
    }
    EXPECT_EQ(deep, least) << id;
  }
}

TEST(Whitman, IsASourceOfProblemsWithOneLibraryAndOneContext) {
  const ProblemSource source = problem_source(load_problem_file("whitman/3g_3o"));
  const auto first = source(Rng{1});
  const auto second = source(Rng{2});
  EXPECT_EQ(&first->library(), &second->library());
  ASSERT_EQ(first->context().size(), second->context().size());
  EXPECT_NE(first->context(), second->context());
}

TEST(Whitman, AsFilesIsTheSameProblem) {
  const test::TemporaryFolder folder;
  folder.write("task.json", whitman_task({}, {.seed = 0, .index = 1}));
  const auto written = load_problem(folder.write("problem.json", whitman_problem("task.json")).string());
  const auto built_in = load_problem("whitman/3g_3o", {.seed = 0, .index = 1});
  EXPECT_EQ(written->context(), built_in->context());
  EXPECT_EQ(written->max_modules(), built_in->max_modules());
  EXPECT_EQ(written->spec().level, built_in->spec().level);
  EXPECT_EQ(written->spec().scoring->name(), built_in->spec().scoring->name());
}

TEST(Whitman, RefusesFreeEndsOfALibraryWithoutEndEffectors) {
  EXPECT_THROW(static_cast<void>(whitman_task({.free_ends = load_library("seed")}, {})), std::invalid_argument);
  const test::TemporaryFolder folder;
  json problem = json::parse(whitman_problem("task.json"));
  problem.erase("task");
  problem["library"] = "seed";
  problem["sampling"] = {{"whitman", {{"goals", 3}, {"boxes", 3}, {"freeEnds", true}}}};
  try {
    static_cast<void>(load_problem_file(folder.write("problem.json", problem.dump()).string()));
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/sampling/whitman/freeEnds"));
    EXPECT_THAT(error.what(), HasSubstr("the library has no end effector"));
  }
}

TEST(Whitman, RefusesNumbersOutsideItsLimits) {
  for (const auto& [goals, boxes, what] : {std::tuple{0, 3, "0 goals"}, std::tuple{3, 21, "21 boxes"}}) {
    try {
      static_cast<void>(whitman_task({.goals = goals, .boxes = boxes}, {}));
      FAIL();
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr(what));
    }
  }
}

}  // namespace
}  // namespace modsearch
