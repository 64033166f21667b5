#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/problem/files.hpp>
#include <nlohmann/json.hpp>
#include <thread>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using test::TemporaryFolder;
using test::text_of;
using ::testing::HasSubstr;

/// The one-module optimum of seed/fixed, with a path of two legs to it.
SolutionRecord best_of_seed_fixed(const RobotProblem& problem) {
  SolutionRecord record;
  record.problem = "seed/fixed";
  const std::vector<int> types{*problem.library().find("hinge")};
  record.design = make_design(problem.library(), types, Eigen::Vector2d{0.5, std::sqrt(1.25) - 0.001});
  record.evaluation = problem.evaluate(record.design);
  const Eigen::MatrixXd& postures = record.evaluation.attempt.postures;
  Path path{Eigen::MatrixXd(3, 2)};
  path.waypoints << 0.0, 0.0, 0.5, -0.125, postures(0, 0), postures(0, 1);
  record.evaluation.attempt.path = path;
  record.evaluation.attempt.goal_waypoints = {2};
  record.verified = "path";
  record.solver = "by hand";
  record.solver_options = {{"care", "much"}, {"haste", "none"}};
  record.seed = 18446744073709551615ULL;
  record.evaluations = 12;
  record.seconds = 0.25;
  return record;
}

class SolutionFile : public ::testing::Test {
 protected:
  std::shared_ptr<const RobotProblem> problem_ = load_problem("seed/fixed");
  SolutionRecord record_ = best_of_seed_fixed(*problem_);
  TemporaryFolder folder_;

  std::filesystem::path write(const json& text) const { return folder_.write("solution.json", text.dump()); }
  json good() const { return json::parse(solution_to_json(*problem_, record_)); }
  std::string refusal(const json& text) const {
    try {
      static_cast<void>(load_solution(write(text)));
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(SolutionFile, ComesBackAsItWasWritten) {
  const auto file = folder_.path() / "solution.json";
  write_solution(file, *problem_, record_);
  const LoadedSolution loaded = load_solution(file);
  EXPECT_TRUE(loaded.claims);
  EXPECT_EQ(loaded.record.design, record_.design);
  EXPECT_EQ(loaded.record.problem, "seed/fixed");
  EXPECT_EQ(loaded.record.evaluation.score, record_.evaluation.score);
  ASSERT_EQ(loaded.record.evaluation.terms.items().size(), record_.evaluation.terms.items().size());
  for (std::size_t i = 0; i < record_.evaluation.terms.items().size(); ++i) {
    EXPECT_EQ(loaded.record.evaluation.terms.items()[i].id, record_.evaluation.terms.items()[i].id);
    EXPECT_EQ(loaded.record.evaluation.terms.items()[i].value, record_.evaluation.terms.items()[i].value);
  }
  EXPECT_TRUE(loaded.record.evaluation.attempt.achieved);
  EXPECT_EQ(loaded.record.evaluation.attempt.goal_error, record_.evaluation.attempt.goal_error);
  EXPECT_EQ(loaded.record.evaluation.attempt.clearance, std::numeric_limits<double>::infinity());
  EXPECT_EQ(loaded.record.evaluation.attempt.postures, record_.evaluation.attempt.postures);
  EXPECT_EQ(loaded.record.solver_options, record_.solver_options);
  EXPECT_EQ(loaded.record.seed, record_.seed);
  EXPECT_EQ(loaded.record.evaluations, 12);
  EXPECT_EQ(loaded.record.verified, "path");
  // Written again, the sampled path gives the same file.
  EXPECT_EQ(solution_to_json(*loaded.problem, loaded.record), text_of(file));
}

TEST_F(SolutionFile, HasCobrasKeys) {
  const json text = good();
  EXPECT_EQ(text["taskID"], "seed/fixed");
  EXPECT_EQ(text["moduleOrder"], (json{"base", "hinge"}));
  EXPECT_EQ(text["moduleConnection"], (json::array({json::array({0, "out", 1, "in"})})));
  EXPECT_EQ(text["baseConnection"], (json::array({json::array({0, "base"})})));
  EXPECT_EQ(text["basePose"].size(), 1U);
  // 1 kg per metre of seed's modules, beside a base that weighs nothing.
  EXPECT_EQ(text["costFunction"], "mass");
  EXPECT_NEAR(text["cost"].get<double>(), record_.design.modules[0].parameters.sum(), 1e-12);
  EXPECT_EQ(text["moduleSet"], "seed");
  EXPECT_EQ(text["computationTime"], 0.25);
  EXPECT_TRUE(text["clearance_m"].is_null());
}

TEST_F(SolutionFile, TimesEachLegByItsSlowestJointInWholeSteps) {
  // The joints have no velocity limit, so 1 rad/s holds: the first leg takes 0.5 s, that is 50 steps of 0.01 s.
  const json trajectory = good()["trajectory"];
  const std::vector<double> t = trajectory["t"];
  const std::vector<std::vector<double>> q = trajectory["q"];
  ASSERT_EQ(t.size(), q.size());
  EXPECT_EQ(q.front(), (std::vector<double>{0.0, 0.0}));
  EXPECT_NEAR(t[50], 0.5, 1e-12);
  EXPECT_EQ(q[50], (std::vector<double>{0.5, -0.125}));  // corners are rows
  EXPECT_NEAR(q[20][0], 0.2, 1e-12);
  EXPECT_NEAR(q[20][1], -0.05, 1e-12);
  const Eigen::MatrixXd& postures = record_.evaluation.attempt.postures;
  EXPECT_EQ(q.back(), (std::vector<double>{postures(0, 0), postures(0, 1)}));
  EXPECT_EQ(trajectory["goal2time"]["1"], t.back());
  for (std::size_t i = 1; i < q.size(); ++i) {
    for (std::size_t j = 0; j < 2; ++j) EXPECT_LE(std::abs(q[i][j] - q[i - 1][j]), 0.01 * (1.0 + 1e-9));
  }
}

TEST_F(SolutionFile, BeginsItsMotionAtHomeHoweverLongTheTimeStep) {
  json file = json::parse(text_of(test::source_folder() / "data/scenarios/seed_fixed.json"));
  file["task"]["header"]["timeStepSize"] = 1e9;
  const auto slow = load_problem(folder_.write("slow.json", file.dump()).string());
  const json trajectory = json::parse(solution_to_json(*slow, record_))["trajectory"];
  // Each of the two legs takes less than a millionth of a step, and is a step nevertheless.
  EXPECT_EQ(trajectory["t"], (json{0.0, 1e9, 2e9}));
  EXPECT_EQ(trajectory["q"][0], (json{0.0, 0.0}));
  EXPECT_EQ(trajectory["q"][1], (json{0.5, -0.125}));
}

TEST_F(SolutionFile, LeavesOutAMotionThatNobodyPlanned) {
  record_.evaluation.attempt.path.reset();
  record_.evaluation.attempt.goal_waypoints.clear();
  record_.verified = "posture";
  EXPECT_FALSE(good().contains("trajectory"));
  EXPECT_FALSE(load_solution(write(good())).record.evaluation.attempt.path.has_value());
}

TEST_F(SolutionFile, OfTheEmptyDesignComesBackToo) {
  SolutionRecord empty;
  empty.problem = "seed/fixed";
  empty.evaluation = problem_->evaluate(empty.design);
  const auto file = folder_.path() / "empty.json";
  write_solution(file, *problem_, empty);
  const LoadedSolution loaded = load_solution(file);
  EXPECT_TRUE(loaded.record.design.modules.empty());
  EXPECT_FALSE(loaded.record.evaluation.attempt.achieved);
  EXPECT_EQ(loaded.record.evaluation.attempt.why, empty.evaluation.attempt.why);
}

TEST_F(SolutionFile, NamesItsInstanceAndTarget) {
  const Instance instance{3, 9};
  const auto problem = load_problem("seed/random_wide", instance);
  SolutionRecord record;
  record.problem = "seed/random_wide";
  record.instance = instance;
  record.target = problem->task().goals()[0].position();
  record.evaluation = problem->evaluate(record.design);
  const auto file = folder_.path() / "instance.json";
  write_solution(file, *problem, record);
  const LoadedSolution loaded = load_solution(file);
  EXPECT_EQ(loaded.problem->task().goals()[0].position(), *record.target);
  EXPECT_EQ(loaded.record.instance->index, 9U);
  json other = json::parse(text_of(file));
  other["instance"]["index"] = 10;
  EXPECT_THAT(refusal(other), HasSubstr("at /instance/target: "));
}

TEST_F(SolutionFile, FindsItsProblemRelativeToItself) {
  const auto scenario = test::source_folder() / "data/scenarios/seed_fixed.json";
  folder_.write("problems/mine.json", text_of(scenario));
  json text = good();
  text["problem"] = "problems/mine.json";
  EXPECT_EQ(load_solution(write(text)).problem->task().name(), "seed/fixed");
  text["problem"] = "problems/lost.json";
  EXPECT_THAT(refusal(text), HasSubstr("at /problem: \"problems/lost.json\" cannot be used"));
  EXPECT_EQ(load_solution(write(text), "seed/fixed").problem->name(), "seed/fixed");
}

TEST_F(SolutionFile, IsADesignFileToo) {
  EXPECT_EQ(load_design(write(good()), problem_->library()), record_.design);
  const auto list = folder_.write("design.json", design_to_json(problem_->library(), record_.design));
  EXPECT_EQ(load_design(list, problem_->library()), record_.design);
}

TEST_F(SolutionFile, IsRefusedWhereItContradictsItself) {
  const auto with = [&](const char* pointer, const json& value) {
    json text = good();
    text[json::json_pointer(pointer)] = value;
    return refusal(text);
  };
  ASSERT_EQ(refusal(good()), "");
  EXPECT_THAT(with("/score", 400.0), HasSubstr("at /score: 400 is not the sum of the terms, 341.9"));
  EXPECT_THAT(with("/score", nullptr), HasSubstr("at /score: null is not the sum of the terms, 341.9"));
  EXPECT_THAT(with("/moduleConnection/0/1", "in"),
              HasSubstr("at /moduleConnection/0: [0,\"in\",1,\"in\"] is not [0,\"out\",1,\"in\"]"));
  EXPECT_THAT(with("/moduleConnection", json::array()), HasSubstr("at /moduleConnection: has 0 connections where the"));
  EXPECT_THAT(with("/computationTime", -1.0), HasSubstr("at /computationTime: -1 is not at least 0"));
  EXPECT_THAT(with("/solver/seed", 1.8446744073709551616e19),
              HasSubstr("at /solver/seed: 1.8446744073709552e+19 is not an integer in [0, 18446744073709551615]"));
  EXPECT_THAT(with("/reached", false), HasSubstr("at /achieved: true is not possible where \"reached\" is false"));
  EXPECT_THAT(with("/taskID", "other"), HasSubstr("at /taskID: \"other\" is not \"seed/fixed\""));
  EXPECT_THAT(with("/moduleOrder/1", "link"), HasSubstr("at /moduleOrder/1: \"link\" is not \"hinge\""));
  EXPECT_THAT(with("/basePose/0/0/3", 0.5), HasSubstr("at /basePose/0: is not where 'seed/fixed' places the base"));
  EXPECT_THAT(with("/design/0/parameters/distal", 1.6),
              HasSubstr("at /design/0/parameters/distal: 1.6 is not in [0.5, 1.5]"));
  EXPECT_THAT(with("/design/0/parameters/width", 1.0), HasSubstr("at /design/0/parameters/width: "));
  EXPECT_THAT(with("/design/0/type", "snake"), HasSubstr("at /design/0/type: \"snake\" is not a module"));
  EXPECT_THAT(with("/postures", json::array()), HasSubstr("at /postures: has 0 rows for 1 goals"));
  EXPECT_THAT(with("/postures/0", {0.0, 0.0, 0.0}), HasSubstr("at /postures/0: [0.0,0.0,0.0] is not a list of 2"));
  EXPECT_THAT(with("/trajectory/t/1", 0.0), HasSubstr("at /trajectory/t/1: 0 is not later than the time before it"));
  EXPECT_THAT(with("/trajectory/t", {0.0}), HasSubstr("at /trajectory/q: has "));
  EXPECT_THAT(with("/trajectory/goal2time/1", 0.123),
              HasSubstr("at /trajectory/goal2time/1: 0.123 is not one of the times"));
  EXPECT_THAT(with("/trajectory/goal2time/1", 0.0), HasSubstr("is not posture 0"));
  EXPECT_THAT(with("/terms/0/name", "luck"), HasSubstr("at /terms/0/name: \"luck\" is not the name of a term"));
  EXPECT_THAT(with("/verified", "surely"), HasSubstr("at /verified: \"surely\" is not one of"));
  EXPECT_THAT(with("/solver/evaluations", -1), HasSubstr("at /solver/evaluations: -1 is not an integer in [0, "));
  EXPECT_THAT(with("/goalError_m", -0.1), HasSubstr("at /goalError_m: -0.1 is not at least 0"));
}

// A solution as CoBRA writes it: no "modsearch", no design, modules without parameters.
TEST_F(SolutionFile, OfCobrasOwnIsReadByItsModules) {
  json problem = json::parse(text_of(test::source_folder() / "data/scenarios/seed_fixed.json"));
  json library = json::parse(text_of(test::source_folder() / "data/libraries/seed.json"));
  json& link = library["modules"][1];  // frozen at 1 m
  link.erase("parameters");
  link["bodies"][0]["mass"] = 1.0;
  link["bodies"][0]["r_com"][2] = 0.5;
  link["bodies"][0]["connectors"][1]["pose"][2][3] = 1.0;
  link["bodies"][0]["collision"][0]["parameters"]["z"] = 1.0;
  link["bodies"][0]["collision"][0]["pose"][2][3] = 0.5;
  problem["library"] = library;
  const std::string file = folder_.write("problem.json", problem.dump()).string();
  json text = {
      {"taskID", "seed/fixed"},
      {"version", "2022"},
      {"moduleOrder", {"base", "link", "link"}},
      {"basePose", {json::parse("[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]")}},
      {"trajectory", {{"t", {0.0, 1.0}}, {"q", {{0.0}, {1.0}}}, {"dq", {{0.0}, {0.0}}}, {"goal2time", {{"1", 1.0}}}}},
      {"cost", 3.0},
      {"costFunction", "cyc"}};
  const LoadedSolution loaded = load_solution(write(text), file);
  EXPECT_FALSE(loaded.claims);
  EXPECT_EQ(loaded.record.design.types(), (std::vector<int>{0, 0}));
  EXPECT_EQ(loaded.record.evaluation.attempt.path->waypoints.rows(), 2);
  EXPECT_FALSE(loaded.record.evaluation.attempt.achieved);
  text["moduleOrder"] = {"base", "hinge"};
  try {
    static_cast<void>(load_solution(write(text), file));
    FAIL() << "was not refused";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("at /moduleOrder/1: the module has parameters, which only \"design\" can give"));
  }
}

TEST_F(SolutionFile, CannotBeWrittenForADesignOutsideTheLibrary) {
  record_.design.modules[0].parameters[0] = 2.0;
  EXPECT_THROW(static_cast<void>(solution_to_json(*problem_, record_)), std::invalid_argument);
}

TEST(WriteFile, ReplacesTheWholeFileAndLeavesNothingBeside) {
  const TemporaryFolder folder;
  const auto file = folder.write("out.txt", "old");
  write_file(file, "new text");
  EXPECT_EQ(text_of(file), "new text");
  write_file(file, "");
  EXPECT_EQ(text_of(file), "");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator{folder.path()}, {}), 1);
}

TEST(WriteFile, KeepsTheOldFileWhereItFails) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_file(folder.path() / "missing" / "out.txt", "text"), FileError);
  std::filesystem::create_directories(folder.path() / "taken" / "inside");
  try {
    write_file(folder.path() / "taken", "text");
    FAIL() << "a directory was replaced";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("taken: cannot be written: "));
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator{folder.path()}, {}), 1);
}

TEST(WriteFile, FollowsLinksAndLeavesDevicesWhatTheyAre) {
  const TemporaryFolder folder;
  const auto file = folder.write("out.txt", "old");
  std::filesystem::create_symlink(file, folder.path() / "link.txt");
  write_file(folder.path() / "link.txt", "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder.path() / "link.txt"));
  EXPECT_EQ(text_of(file), "new");
  std::filesystem::create_symlink("/dev/full", folder.path() / "full");
  EXPECT_THROW(write_file(folder.path() / "full", "text"), FileError);
  EXPECT_FALSE(std::filesystem::is_regular_file("/dev/full"));
}

TEST(WriteFile, IsWholeWhoeverWritesAtTheSameTime) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "out.txt";
  const std::string a(100'000, 'a');
  const std::string b(100'000, 'b');
  std::thread first{[&] {
    for (int i = 0; i < 20; ++i) write_file(file, a);
  }};
  std::thread second{[&] {
    for (int i = 0; i < 20; ++i) write_file(file, b);
  }};
  first.join();
  second.join();
  const std::string text = text_of(file);
  EXPECT_TRUE(text == a || text == b);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator{folder.path()}, {}), 1);
}

}  // namespace
}  // namespace modsearch
