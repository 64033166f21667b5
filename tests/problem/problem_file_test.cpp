#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <nlohmann/json.hpp>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using test::TemporaryFolder;
using test::text_of;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::filesystem::path kData = test::source_folder() / "data";

json seed_fixed() { return json::parse(text_of(kData / "scenarios/seed_fixed.json")); }

TEST(ProblemFile, KnowsTheReferenceScenariosById) {
  for (const char* id : {"seed/fixed", "seed/random_narrow", "seed/random_obstacles", "seed/random_wide"}) {
    EXPECT_THAT(builtin_problems(), Contains(id));
    const auto problem = load_problem(id);
    EXPECT_EQ(problem->name(), id);
    EXPECT_EQ(problem->max_modules(), 10);
    EXPECT_EQ(problem->spec().level, Level::kPosture);
    EXPECT_EQ(problem->spec().scoring->name(), "algorithm1");
    EXPECT_EQ(problem->task().name(), id);
  }
}

TEST(ProblemFile, OfEveryBuiltInProblemIsNamedAsItsTask) {
  for (const std::string& id : builtin_problems()) {
    if (load_problem_file(id).whitman) continue;  // the tasks of a generated family have names of their own
    EXPECT_EQ(load_problem(id)->task().name(), id);
  }
  EXPECT_THAT(builtin_libraries(), ElementsAre("seed", "seed/short", "workshop"));
}

TEST(ProblemFile, OfTheHarderFamiliesDifferInLengthsGoalsAndClutter) {
  const auto library = load_problem("breakeven/short")->spec().library;
  const ModuleType& hinge = library->type(library->find("hinge").value());
  EXPECT_EQ(hinge.parameters[0].lower, 0.2);
  EXPECT_EQ(hinge.parameters[1].upper, 0.6);
  EXPECT_EQ(load_problem("breakeven/two_goals")->task().goals().size(), 2U);
  EXPECT_EQ(load_problem("breakeven/three_goals")->task().goals().size(), 3U);
  EXPECT_EQ(load_problem("breakeven/clutter")->scene().obstacles().size(), 6U);
  EXPECT_EQ(load_problem("breakeven/clutter_path")->spec().level, Level::kPath);
}

TEST(ProblemFile, OfTheFixedScenarioAsksForOnePointWithinAMillimetre) {
  const auto problem = load_problem("seed/fixed");
  ASSERT_EQ(problem->task().goals().size(), 1U);
  const Goal& goal = problem->task().goals()[0];
  EXPECT_EQ(goal.type, GoalType::kReach);
  EXPECT_EQ(goal.position(), (Eigen::Vector3d{1.0, 0.0, 1.0}));
  EXPECT_TRUE(goal.region.is_ball());
  EXPECT_EQ(goal.region.tolerances()[0].upper, 0.001);
  EXPECT_TRUE(problem->scene().obstacles().empty());
}

TEST(ProblemFile, HasTheBoxesAndObstaclesOfTheReport) {
  const auto box = [](const char* id) {
    const Sampling sampling = *load_problem_file(id).sampling;
    EXPECT_EQ(sampling.min_clearance, 0.055);
    return std::pair{sampling.lower, sampling.upper};
  };
  using V = Eigen::Vector3d;
  EXPECT_EQ(box("seed/random_narrow"), (std::pair{V{0, 0, 1}, V{1, 1, 1.6}}));
  EXPECT_EQ(box("seed/random_wide"), (std::pair{V{0, 0, 0}, V{1, 1, 2}}));
  EXPECT_EQ(box("seed/random_obstacles"), (std::pair{V{0, 0, 1}, V{1, 1, 2}}));
  const auto scene = load_problem_file("seed/random_obstacles").spec.scene;
  ASSERT_EQ(scene->obstacles().size(), 3U);
  // Distances by hand: from the centres of the two spheres and from the middle of the box's top face.
  EXPECT_NEAR(scene->clearance(V{-0.5, 0.5, 1.2}), -0.3, 1e-12);
  EXPECT_NEAR(scene->clearance(V{0.3, 0.3, 0.9}), -0.2, 1e-12);
  EXPECT_NEAR(scene->clearance(V{0.7, 0.6, 0.85}), 0.1, 1e-12);
}

TEST(ProblemFile, FindsTaskAndLibraryBesideIt) {
  const TemporaryFolder folder;
  json problem = seed_fixed();
  folder.write("tasks/task.json", problem["task"].dump());
  folder.write("library.json", text_of(kData / "libraries/seed.json"));
  problem["task"] = "tasks/task.json";
  problem["library"] = "library.json";
  const auto file = folder.write("problem.json", problem.dump());
  const auto loaded = load_problem(file.string());
  EXPECT_EQ(loaded->library().n_types(), 3);
  EXPECT_EQ(loaded->task().goals().size(), 1U);
}

TEST(ProblemFile, MayHoldItsLibrary) {
  const TemporaryFolder folder;
  json problem = seed_fixed();
  problem["library"] = json::parse(text_of(kData / "libraries/seed.json"));
  EXPECT_EQ(load_problem(folder.write("problem.json", problem.dump()).string())->library().n_types(), 3);
}

TEST(ProblemFile, NamesBothFilesWhereTheOneItRefersToIsBroken) {
  const TemporaryFolder folder;
  json problem = seed_fixed();
  problem["task"]["goals"][0]["type"] = "dance";
  folder.write("task.json", problem["task"].dump());
  problem["task"] = "task.json";
  const auto file = folder.write("problem.json", problem.dump());
  try {
    static_cast<void>(load_problem(file.string()));
    FAIL() << "was not refused";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr(file.string() + " -> " + (folder.path() / "task.json").string() +
                                        ": at /goals/0/type: \"dance\" is not one of"));
  }
}

TEST(ProblemFile, ReadsEveryLevelAndTheWeights) {
  const TemporaryFolder folder;
  for (const Level level : {Level::kNone, Level::kPosture, Level::kPostureSelf, Level::kPath}) {
    json problem = seed_fixed();
    problem["collision"] = std::string{name(level)};
    problem["scoring"] = {{"type", "weighted"}, {"reached", 100}, {"mass", 2.5}};
    const auto loaded = load_problem(folder.write("problem.json", problem.dump()).string());
    EXPECT_EQ(loaded->spec().level, level);
    EXPECT_EQ(loaded->spec().scoring->name(), "weighted");
    EXPECT_EQ(loaded->spec().scoring->mass_weight(), 2.5);
  }
}

TEST(ProblemFile, ListsTheBuiltInOnesWhereTheIdIsUnknown) {
  try {
    static_cast<void>(load_problem("seed/moving"));
    FAIL() << "was not refused";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("seed/moving: there is no such file and no built-in problem with this ID"));
    EXPECT_THAT(error.what(), HasSubstr("seed/fixed"));
  }
}

}  // namespace
}  // namespace modsearch
