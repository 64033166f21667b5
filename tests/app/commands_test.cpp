#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <modsearch/baselines/random_search.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/solvers/checkpoint.hpp>
#include <nlohmann/json.hpp>
#include <tuple>

#include "app/command.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::modsearch;
using ::testing::Not;
using testing::Outcome;
using testing::read_text;
using ::testing::StartsWith;
using testing::TemporaryFolder;

void write(const std::string& file, const std::string& text) { std::ofstream{file} << text; }

json far_problem() {
  return {{"modsearch", 1},
          {"library", "seed"},
          {"maxModules", 10},
          {"collision", "posture"},
          {"scoring", {{"type", "algorithm1"}}},
          {"task",
           {{"header", {{"ID", "far"}, {"version", "2022"}, {"timeStepSize", 0.01}, {"gravity", {0, 0, -9.81}}}},
            {"obstacles", json::array()},
            {"constraints", json::array()},
            {"goals",
             {{{"ID", "1"},
               {"type", "reach"},
               {"goalPose",
                {{"nominal", {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 50}, {0, 0, 0, 1}}},
                 {"toleranceProjection", {"r_sph"}},
                 {"tolerance", {{0, 0.001}}}}}}}}}}};
}

/// A solution as CoBRA has it: design and motion, and nothing of ours about how good they are.
json without_claims(json solution) {
  for (const char* ours : {"modsearch", "score", "terms", "reached", "achieved", "goalError_m", "clearance_m",
                           "postures", "verified", "solver"}) {
    solution.erase(ours);
  }
  return solution;
}

TEST(Solve, WritesASolutionATraceAndAPageThatVerify) {
  const TemporaryFolder folder;
  const Outcome solved =
      modsearch({"solve", "seed/random_obstacles", "--instance", "0:3", "--out", folder / "out"}, folder);
  EXPECT_EQ(solved.status, 0) << solved.err;
  EXPECT_THAT(solved.out, HasSubstr("achieved"));
  EXPECT_THAT(solved.out, HasSubstr("verified     path"));
  EXPECT_THAT(read_text(folder / "out/trace.csv"), StartsWith("evaluations,seconds,score,achieved\n"));
  EXPECT_THAT(read_text(folder / "out/view.html"), HasSubstr("<!DOCTYPE html>"));
  const json solution = json::parse(read_text(folder / "out/solution.json"));
  EXPECT_EQ(solution.at("problem"), "seed/random_obstacles");
  EXPECT_EQ(solution.at("instance").at("index"), 3);
  EXPECT_EQ(solution.at("verified"), "path");

  const Outcome verified = modsearch({"verify", folder / "out/solution.json"}, folder);
  EXPECT_EQ(verified.status, 0) << verified.out << verified.err;
  EXPECT_THAT(verified.out, StartsWith("verified"));
}

TEST(Solve, SpeaksJsonAndNothingElseOnStdout) {
  const TemporaryFolder folder;
  for (const char* solver : {"auto", "per-sequence:inner=ipopt,starts=2", "per-sequence:inner=ceres"}) {
    const Outcome solved = modsearch({"solve", "seed/fixed", "--solver", solver, "--json", "--quiet"}, folder);
    EXPECT_EQ(solved.status, 0);
    const json answer = json::parse(solved.out);
    EXPECT_GE(answer.at("score").get<double>(), 341.91) << solver;
    EXPECT_EQ(answer.at("modules"), 2);
    EXPECT_EQ(answer.at("achieved"), true);
    EXPECT_EQ(answer.at("verified"), true);
    EXPECT_EQ(answer.at("design").at(0).at("type"), "hinge");
    EXPECT_EQ(solved.err, "") << solver;
  }
}

TEST(Solve, GivesTheSameAnswerTwice) {
  const TemporaryFolder folder;
  const auto answer = [&] {
    json result = json::parse(modsearch({"solve", "seed/random_wide", "--instance", "7:1", "--solver", "random",
                                         "--evaluations", "2000", "--seed", "3", "--json"},
                                        folder)
                                  .out);
    result.erase("seconds");
    return result;
  };
  EXPECT_EQ(answer(), answer());
}

TEST(Solve, GoesOnFromItsCheckpointToTheSameAnswer) {
  const TemporaryFolder folder;
  const auto solve = [&](const std::string& evaluations, const std::vector<std::string>& more) {
    std::vector<std::string> words{"solve", "seed/random_obstacles", "--solver", "random", "--evaluations", evaluations,
                                   "--json"};
    words.insert(words.end(), more.begin(), more.end());
    json answer = json::parse(modsearch(words, folder).out);
    answer.erase("seconds");
    return answer;
  };
  const std::string file = folder / "search.bin";
  (void)solve("500", {"--checkpoint", file});
  ASSERT_TRUE(std::filesystem::exists(file));
  EXPECT_EQ(solve("1000", {"--checkpoint", file, "--resume"}), solve("1000", {}));
  const auto refused = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"solve", "seed/random_obstacles", "--solver", "random", "--checkpoint", file};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = modsearch(words, folder);
    EXPECT_EQ(outcome.status, 2);
    return outcome.err;
  };
  EXPECT_THAT(refused({}), HasSubstr("--resume goes on with it"));
  EXPECT_THAT(refused({"--resume", "--seed", "7"}),
              HasSubstr("is 'random, seed 0', this search is of 'random, seed 7'"));
  const Outcome nowhere = modsearch({"solve", "seed/fixed", "--resume"}, folder);
  EXPECT_EQ(nowhere.status, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("--checkpoint"));
}

TEST(Solve, EndsWithOneAndTheReasonForATargetBeyondEveryReach) {
  const TemporaryFolder folder;
  write(folder / "far.json", far_problem().dump());
  const Outcome solved = modsearch({"solve", folder / "far.json"}, folder);
  EXPECT_EQ(solved.status, 1) << solved.err;
  EXPECT_THAT(solved.out, HasSubstr("unreachable"));
  EXPECT_THAT(solved.out, HasSubstr("50 m away from the base"));
}

TEST(Solve, SaysAtOnceWhichGoalLiesInWhichObstacleForEveryEnd) {
  const TemporaryFolder folder;
  const Outcome solved = modsearch({"solve", "whitman/3g_3o", "--instance", "0:6"}, folder);
  EXPECT_EQ(solved.status, 1) << solved.err;
  EXPECT_THAT(solved.out, HasSubstr("proved infeasible: goal '3' lies in obstacle 'box 1' for every end effector"));
  const Outcome told = modsearch({"solve", "whitman/3g_3o", "--instance", "0:6", "--solver", "ga", "--json"}, folder);
  EXPECT_EQ(told.status, 1) << told.err;
  const json answer = json::parse(told.out);
  EXPECT_EQ(answer.at("stop"), "unreachable");
  EXPECT_EQ(answer.at("infeasible").at("goal"), "3");
  EXPECT_EQ(answer.at("infeasible").at("obstacle"), "box 1");
  EXPECT_EQ(answer.at("infeasible").at("module"), "gripper_60");
  EXPECT_GT(answer.at("infeasible").at("depth_m").get<double>(), 0.004);
}

TEST(Solve, StopsOnCtrlCAndWritesWhatThereIs) {
  const TemporaryFolder folder;
  const testing::Child child{
      {"solve", "seed/fixed", "--solver", "random", "--evaluations", "1000000000", "--json", "--out", folder / "out"},
      folder.path()};
  std::this_thread::sleep_for(std::chrono::milliseconds{700});  // for the program to have begun; a second is no limit
  child.interrupt();
  const Outcome outcome = child.wait();
  EXPECT_EQ(outcome.status, 130);
  EXPECT_EQ(json::parse(outcome.out).at("stop"), "interrupted");
  EXPECT_TRUE(std::filesystem::exists(folder / "out/solution.json"));
}

TEST(Solve, KeepsItsProgressOnOneLineOfTheTerminal) {
  const std::string seen = testing::on_terminal({"solve", "seed/fixed", "--solver", "random", "--seconds", "0.5"}, 40);
  std::size_t bars = 0;
  for (std::size_t at = seen.find("\r\033[K["); at != std::string::npos; at = seen.find("\r\033[K[", at + 1)) {
    const std::size_t begin = at + 4;  // behind what takes the last bar off
    EXPECT_LT(seen.find('\r', begin) - begin, 40U);
    ++bars;
  }
  EXPECT_GE(bars, 1U);
  EXPECT_THAT(seen, HasSubstr("\r\033[Kproblem"));
}

TEST(Solve, HonoursABudgetOfSeconds) {
  const TemporaryFolder folder;
  const Outcome solved = modsearch({"solve", "seed/fixed", "--solver", "random", "--seconds", "0.2", "--json"}, folder);
  const json answer = json::parse(solved.out);
  EXPECT_EQ(answer.at("stop"), "seconds");
  EXPECT_GE(answer.at("seconds").get<double>(), 0.2);
}

TEST(Solve, SaysThatNothingWasEvaluatedRatherThanThatTheGoalIsMet) {
  const TemporaryFolder folder;
  const std::vector<std::string> command = {"solve", "seed/fixed", "--evaluations", "0", "--out", folder / "out"};
  const Outcome text = modsearch(command, folder);
  EXPECT_EQ(text.status, 1);
  EXPECT_THAT(text.out, HasSubstr("none: nothing was evaluated"));
  EXPECT_THAT(text.out, Not(HasSubstr("goal error")));
  EXPECT_TRUE(json::parse(read_text(folder / "out/solution.json")).at("goalError_m").is_null());
  std::vector<std::string> with_json = command;
  with_json.push_back("--json");
  const json answer = json::parse(modsearch(with_json, folder).out);
  EXPECT_TRUE(answer.at("goalError_m").is_null());
  EXPECT_TRUE(answer.at("score").is_null());
  EXPECT_EQ(answer.at("why"), "nothing was evaluated");
}

TEST(Solve, TellsWhatItFoundEvenWhereItCannotBeWritten) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "out/view.html");  // a folder where the page has to go
  const Outcome solved = modsearch({"solve", "seed/fixed", "--out", folder / "out"}, folder);
  EXPECT_EQ(solved.status, 2);
  EXPECT_THAT(solved.out, HasSubstr("341.914830"));
  EXPECT_THAT(solved.err, HasSubstr("view.html: cannot be written: Is a directory"));
}

TEST(Solve, RefusesAFolderThatItMayNotWriteIntoBeforeItSearches) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "out");
  std::filesystem::permissions(folder / "out", std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  const Outcome solved = modsearch({"solve", "seed/fixed", "--out", folder / "out"}, folder);
  EXPECT_EQ(solved.status, 2);
  EXPECT_EQ(solved.out, "");
  EXPECT_THAT(solved.err, HasSubstr("cannot write into this folder: Permission denied"));
}

TEST(Solve, FailsWhereItsAnswerCannotBeWrittenToStdout) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const TemporaryFolder folder;
  for (const char* format : {"--json", "--quiet"}) {
    const Outcome solved = testing::Child{{"solve", "seed/fixed", format}, folder.path(), "/dev/full"}.wait();
    EXPECT_EQ(solved.status, 2) << format;
    EXPECT_THAT(solved.err, HasSubstr("standard output cannot be written: No space left on device"));
  }
}

TEST(Solve, TakesAnInstanceOfASampledProblemOnly) {
  const TemporaryFolder folder;
  EXPECT_EQ(modsearch({"solve", "seed/fixed", "--instance", "0:0"}, folder).status, 0);  // the only one that there is
  const Outcome refused = modsearch({"solve", "seed/fixed", "--instance", "0:3"}, folder);
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("seed/fixed is not sampled"));
}

TEST(Solve, BlamesTheFileWhereNoTargetCanBeDrawn) {
  const TemporaryFolder folder;
  json problem = far_problem();
  problem["task"]["obstacles"] = {
      {{"ID", "ball"}, {"collision", {{{"type", "sphere"}, {"parameters", {{"r", 1.0}}}}}}}};
  problem["sampling"] = {
      {"goal", "1"}, {"box", {{"lower", {0, 0, 0}}, {"upper", {0.1, 0.1, 0.1}}}}, {"minClearance", 0.1}};
  write(folder / "within.json", problem.dump());
  const Outcome within = modsearch({"solve", folder / "within.json"}, folder);
  EXPECT_EQ(within.status, 2);
  EXPECT_THAT(within.err, HasSubstr("within.json: instance 0:0: 10000 targets in a row"));

  problem["sampling"] = {{"goal", "1"}, {"box", {{"lower", {-1.7e308, 0, 0}}, {"upper", {1.7e308, 0, 0}}}}};
  write(folder / "endless.json", problem.dump());
  const Outcome endless = modsearch({"solve", folder / "endless.json"}, folder);
  EXPECT_EQ(endless.status, 2);
  EXPECT_THAT(endless.err, HasSubstr("endless.json: instance 0:0: "));
}

TEST(Solve, TakesAGoalThatAsksForNothing) {
  const TemporaryFolder folder;
  json problem = far_problem();
  json& pose = problem["task"]["goals"][0]["goalPose"];
  pose["toleranceProjection"] = json::array();
  pose["tolerance"] = json::array();
  write(folder / "any.json", problem.dump());
  const Outcome solved = modsearch({"solve", folder / "any.json", "--out", folder / "out"}, folder);
  EXPECT_EQ(solved.status, 0) << solved.err;
  EXPECT_EQ(modsearch({"verify", folder / "out/solution.json"}, folder).status, 0);
}

TEST(Solve, WritesAMotionThatVerifiesHoweverLongTheTimeStep) {
  const TemporaryFolder folder;
  json problem = far_problem();
  problem["task"]["header"]["timeStepSize"] = 1e9;
  problem["task"]["goals"][0]["goalPose"]["nominal"] = {{1, 0, 0, 1}, {0, 1, 0, 0}, {0, 0, 1, 1}, {0, 0, 0, 1}};
  write(folder / "slow.json", problem.dump());
  ASSERT_EQ(modsearch({"solve", folder / "slow.json", "--out", folder / "out"}, folder).status, 0);
  const Outcome verified = modsearch({"verify", folder / "out/solution.json"}, folder);
  EXPECT_EQ(verified.status, 0) << verified.out << verified.err;
}

TEST(Solve, TakesFolderNamesOfAnyKind) {
  const TemporaryFolder folder;
  for (const char* name : {"with space", "\xc3\xbc\xe2\x98\x83 'quoted\"", "not UTF-8 \xff"}) {
    const std::string out = folder / name;
    const Outcome solved = modsearch({"solve", "seed/fixed", "--json", "--out", out}, folder);
    EXPECT_EQ(solved.status, 0) << name << solved.err;
    EXPECT_TRUE(json::accept(solved.out)) << name;
    EXPECT_EQ(modsearch({"verify", out + "/solution.json"}, folder).status, 0) << name;
  }
}

TEST(Solve, RaisesTheCollisionLevelToPathOnDemand) {
  const TemporaryFolder folder;
  const Outcome solved =
      modsearch({"solve", "seed/fixed", "--fidelity", "path", "--json", "--out", folder / "out"}, folder);
  EXPECT_EQ(solved.status, 0);
  const json solution = json::parse(read_text(folder / "out/solution.json"));
  EXPECT_GE(solution.at("trajectory").at("q").size(), 2u);
}

TEST(Verify, RefusesATamperedScore) {
  const TemporaryFolder folder;
  ASSERT_EQ(modsearch({"solve", "seed/fixed", "--out", folder / "out"}, folder).status, 0);
  json solution = json::parse(read_text(folder / "out/solution.json"));
  solution["score"] = solution["score"].get<double>() + 3.0;
  for (json& term : solution["terms"]) {
    if (term["name"] == "mass") term["value"] = term["value"].get<double>() + 3.0;
  }
  write(folder / "out/solution.json", solution.dump());
  const Outcome verified = modsearch({"verify", folder / "out/solution.json"}, folder);
  EXPECT_EQ(verified.status, 1) << verified.err;
  EXPECT_THAT(verified.out, HasSubstr("344.91483"));
}

TEST(Verify, RefusesAFileThatContradictsItself) {
  const TemporaryFolder folder;
  ASSERT_EQ(modsearch({"solve", "seed/fixed", "--out", folder / "out"}, folder).status, 0);
  json solution = json::parse(read_text(folder / "out/solution.json"));
  solution["score"] = 345.0;  // no longer the sum of the terms
  write(folder / "out/solution.json", solution.dump());
  const Outcome verified = modsearch({"verify", folder / "out/solution.json"}, folder);
  EXPECT_EQ(verified.status, 2);
  EXPECT_THAT(verified.err, HasSubstr("345"));
}

TEST(Verify, RefusesADesignThatMissesTheTarget) {
  const TemporaryFolder folder;
  ASSERT_EQ(modsearch({"solve", "seed/fixed", "--out", folder / "out"}, folder).status, 0);
  json solution = json::parse(read_text(folder / "out/solution.json"));
  solution["design"][0]["parameters"]["distal"] = 1.3;
  write(folder / "out/solution.json", solution.dump());
  const Outcome verified = modsearch({"verify", folder / "out/solution.json"}, folder);
  EXPECT_EQ(verified.status, 1) << verified.err;
  EXPECT_THAT(verified.out, HasSubstr("unreachable"));
}

TEST(Verify, RefusesLengthsThatAreNotTrue) {
  const TemporaryFolder folder;
  ASSERT_EQ(modsearch({"solve", "seed/random_obstacles", "--instance", "0:3", "--out", folder / "out"}, folder).status,
            0);
  const json solution = json::parse(read_text(folder / "out/solution.json"));
  for (const auto& [key, value, words] : std::vector<std::tuple<std::string, json, std::string>>{
           {"clearance_m", 0.5, "the clearance is 0.0671 m, not 0.5 m as claimed"},
           {"clearance_m", nullptr, "not inf m as claimed"},
           {"goalError_m", 0.0, "the goal error is 0.0009999 m, not 0 m as claimed"}}) {
    json altered = solution;
    altered[key] = value;
    write(folder / "out/solution.json", altered.dump());
    const Outcome verified = modsearch({"verify", folder / "out/solution.json"}, folder);
    EXPECT_EQ(verified.status, 1) << key;
    EXPECT_THAT(verified.out, HasSubstr(words));
  }
}

TEST(Verify, HoldsNoClaimsAgainstAFileThatMakesNone) {
  const TemporaryFolder folder;
  ASSERT_EQ(modsearch({"solve", "seed/fixed", "--out", folder / "out"}, folder).status, 0);
  write(folder / "out/solution.json", without_claims(json::parse(read_text(folder / "out/solution.json"))).dump());
  const Outcome verified = modsearch({"verify", folder / "out/solution.json"}, folder);
  EXPECT_EQ(verified.status, 0) << verified.out << verified.err;
}

TEST(Evaluate, ShowsTheScoreTermByTerm) {
  const TemporaryFolder folder;
  write(folder / "design.json", R"([{"type": "hinge", "parameters": {"proximal": 0.5, "distal": 1.118}}])");
  const Outcome text = modsearch({"evaluate", "seed/fixed", folder / "design.json"}, folder);
  EXPECT_EQ(text.status, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("reached    +350"));
  const json answer = json::parse(modsearch({"evaluate", "seed/fixed", folder / "design.json", "--json"}, folder).out);
  double sum = 0.0;
  for (const json& term : answer.at("terms")) sum += term.at("value").get<double>();
  EXPECT_DOUBLE_EQ(sum, answer.at("score"));
  EXPECT_NEAR(sum, 350.0 - 5.0 * 1.618, 1e-9);
}

TEST(Evaluate, EndsWithZeroForAnyValidDesign) {
  const TemporaryFolder folder;
  write(folder / "empty.json", "[]");
  EXPECT_EQ(modsearch({"evaluate", "seed/fixed", folder / "empty.json"}, folder).status, 0);
}

TEST(Evaluate, TakesTheInstanceThatASolutionNames) {
  const TemporaryFolder folder;
  const Outcome solved =
      modsearch({"solve", "seed/random_obstacles", "--instance", "0:3", "--json", "--out", folder / "out"}, folder);
  ASSERT_EQ(solved.status, 0) << solved.err;
  const std::string file = folder / "out/solution.json";
  const json own = json::parse(modsearch({"evaluate", "seed/random_obstacles", file, "--json"}, folder).out);
  EXPECT_EQ(own.at("instance"), (json{{"seed", 0}, {"index", 3}}));
  EXPECT_EQ(own.at("score"), json::parse(solved.out).at("score"));
  const Outcome other =
      modsearch({"evaluate", "seed/random_obstacles", file, "--instance", "0:0", "--json"}, folder);
  EXPECT_NE(json::parse(other.out).at("score"), own.at("score"));
}

TEST(Render, MakesThePageOfASolution) {
  const TemporaryFolder folder;
  ASSERT_EQ(modsearch({"solve", "seed/fixed", "--out", folder / "out"}, folder).status, 0);
  const Outcome rendered = modsearch({"render", folder / "out/solution.json", "--out", folder / "page"}, folder);
  EXPECT_EQ(rendered.status, 0) << rendered.err;
  EXPECT_THAT(read_text(folder / "page/view.html"), HasSubstr("<!DOCTYPE html>"));
}

TEST(Render, TellsHowToSolveItAgainAndWhereTargetsAreSampled) {
  const TemporaryFolder folder;
  ASSERT_EQ(modsearch({"solve", "seed/random_wide", "--instance", "0:1", "--solver",
                       "per-sequence:inner=slsqp,starts=4", "--seed", "7", "--out", folder / "out"},
                      folder)
                .status,
            0);
  const int evaluations = json::parse(read_text(folder / "out/solution.json")).at("solver").at("evaluations");
  ASSERT_EQ(modsearch({"render", folder / "out/solution.json", "--out", folder / "out"}, folder).status, 0);
  const std::string page = read_text(folder / "out/view.html");
  EXPECT_THAT(page, HasSubstr("\"command\":\"modsearch solve seed/random_wide --instance 0:1 --solver "
                              "per-sequence:inner=slsqp,starts=4 --seed 7 --evaluations " +
                              std::to_string(evaluations) + "\""));
  EXPECT_THAT(page, HasSubstr("\"region\":{\"lower\":[0.0,0.0,0.0],\"upper\":[1.0,1.0,2.0]}"));
}

TEST(Render, EvaluatesADesignOfWhichTheFileClaimsNothing) {
  const TemporaryFolder folder;
  ASSERT_EQ(modsearch({"solve", "seed/fixed", "--out", folder / "out"}, folder).status, 0);
  write(folder / "out/solution.json", without_claims(json::parse(read_text(folder / "out/solution.json"))).dump());
  ASSERT_EQ(modsearch({"render", folder / "out/solution.json", "--out", folder / "out"}, folder).status, 0);
  const std::string page = read_text(folder / "out/view.html");
  EXPECT_THAT(page, HasSubstr("\"achieved\":true"));
  EXPECT_THAT(page, HasSubstr("\"score\":341.9148"));
}

TEST(Render, EndsAtTheFirstCtrlC) {
  const TemporaryFolder folder;
  ASSERT_EQ(modsearch({"solve", "seed/fixed", "--out", folder / "out"}, folder).status, 0);
  const testing::StuckChild child{{"render", folder / "out/solution.json"}};  // the page is longer than any pipe
  EXPECT_EQ(child.signal_after_interrupt(), SIGINT);
}

TEST(List, ShowsSolversWithOptionsAndProblems) {
  const TemporaryFolder folder;
  const Outcome solvers = modsearch({"list", "solvers"}, folder);
  EXPECT_EQ(solvers.status, 0);
  for (const char* name : {"auto", "random", "per-sequence", "ipopt|slsqp", "starts"}) {
    EXPECT_THAT(solvers.out, HasSubstr(name));
  }
  const json problems = json::parse(modsearch({"list", "problems", "--json"}, folder).out);
  std::vector<std::string> ids;
  for (const json& problem : problems) ids.push_back(problem.at("id"));
  EXPECT_THAT(ids, ::testing::IsSupersetOf({"breakeven/clutter_path", "seed/fixed", "seed/random_wide"}));
}

TEST(ListCommand, NamesLibrariesPoliciesAndWhatPresetsSet) {
  const TemporaryFolder folder;
  EXPECT_THAT(modsearch({"list", "libraries"}, folder).out, HasSubstr("workshop"));
  EXPECT_THAT(modsearch({"list", "solvers"}, folder).out, HasSubstr("policy:FILE"));
  const std::string agents = modsearch({"list", "agents"}, folder).out;
  EXPECT_THAT(agents, ::testing::ContainsRegex("what preset=best, drawn targets sets otherwise\n    .*polish="));
}

TEST(BadUsage, EndsWithTwoAndOneSentence) {
  const TemporaryFolder folder;
  write(folder / "broken.json", "{\"modsearch\": 1,");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"solve", "no/such.json"}, "no/such.json"},
      {{"solve", folder / "broken.json"}, "broken.json"},
      {{"solve", "seed/fixed", "--solver", "magic"}, "'magic' is not one of auto, random, per-sequence"},
      {{"solve", "seed/fixed", "--solver", "per-sequence:inner=magic"}, "inner=magic"},
      {{"solve", "seed/fixed", "--solver", "per-sequence:starts=0"}, "starts=0: not an integer in [1, 100000]"},
      {{"solve", "seed/fixed", "--solver", "random:x=1"}, "no option 'x'"},
      {{"solve", "seed/fixed", "--instance", "3"}, "SEED:INDEX"},
      {{"solve", "seed/fixed", "--solver", "auto:"}, "'' is not of the form key=value"},
      {{"solve", "seed/fixed", "--solver", "per-sequence:starts=2,"}, "'' is not of the form key=value"},
      {{"solve", ""}, "PROBLEM is empty"},
      {{"solve", "seed/fixed", "--out", ""}, "--out is empty"},
      {{"solve", "seed/fixed", "--seed", "-1"}, "--seed -1: not a whole number in [0, 18446744073709551615]"},
      {{"solve", "seed/fixed", "--seed", "18446744073709551616"}, "--seed 18446744073709551616: not a whole number"},
      {{"solve", "seed/fixed", "--evaluations", "-1"}, "--evaluations -1: not a whole number"},
      {{"solve", "seed/fixed", "--evaluations", "1e3"}, "--evaluations 1e3: not a whole number"},
      {{"solve", "seed/fixed", "--evaluations", "9223372036854775808"}, "in [0, 9223372036854775807]"},
      {{"solve", "seed/fixed", "--seconds", "nan"}, "--seconds nan: not a number in [0, 1e+09]"},
      {{"solve", "seed/fixed", "--seconds", "inf"}, "--seconds inf: not a number in [0, 1e+09]"},
      {{"solve", "seed/fixed", "--seconds", "-1"}, "--seconds -1: not a number in [0, 1e+09]"},
      {{"solve", "seed/fixed", "--fidelity", "high"}, "--fidelity"},
      {{"evaluate", "seed/fixed", folder / "broken.json"}, "broken.json"},
      {{"verify", folder / "broken.json"}, "broken.json"},
      {{"train", "seed/fixed", "--agent", "mpdqn:actor_hidden=1000000"}, "actor = 1000000, not in [1, 16384]"},
      {{"list", "planets"}, "planets"},
      {{"fly"}, "fly"},
  };
  for (const auto& [arguments, part] : cases) {
    const Outcome outcome = modsearch(arguments, folder);
    EXPECT_EQ(outcome.status, 2) << arguments.back();
    EXPECT_THAT(outcome.err, StartsWith("modsearch: "));
    EXPECT_THAT(outcome.err, HasSubstr(part));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_EQ(outcome.out, "");
  }
}

TEST(BadUsage, WithoutACommandNamesThemAll) {
  const TemporaryFolder folder;
  const Outcome outcome = modsearch({}, folder);
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err,
            "modsearch: no command given: one of solve, train, compare, evaluate, verify, render, convert, generate, "
            "certify, check-certificate, best-known, list\n");
}

TEST(Help, ShowsAnExampleForEverySubcommand) {
  const TemporaryFolder folder;
  for (const char* command : {"solve", "compare", "evaluate", "verify", "render", "list"}) {
    const Outcome help = modsearch({command, "--help"}, folder);
    EXPECT_EQ(help.status, 0);
    EXPECT_THAT(help.out, HasSubstr(std::string{"Example:\n  modsearch "} + command));
  }
}

TEST(ListCommand, ShowsTheAgentsWithTheirOptions) {
  const TemporaryFolder folder;
  const Outcome outcome = modsearch({"list", "agents", "--json"}, folder);
  ASSERT_EQ(outcome.status, 0);
  const json agents = json::parse(outcome.out);
  ASSERT_EQ(agents.size(), 5U);
  EXPECT_EQ(agents[1]["name"], "mpdqn");
  EXPECT_GT(agents[1]["options"].size(), 40U);
}

}  // namespace
}  // namespace modsearch
