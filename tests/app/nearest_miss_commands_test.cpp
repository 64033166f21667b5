#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/command.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::modsearch;
using testing::Outcome;
using testing::read_text;
using testing::TemporaryFolder;

void write(const std::string& file, const std::string& text) { std::ofstream{file} << text; }

// A goal 50 m above the base, which no design reaches.
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

TEST(Solve, NamesTheNearestMissOfAnAnswerThatIsNotAchieved) {
  const TemporaryFolder folder;
  write(folder / "far.json", far_problem().dump());
  const std::vector<std::string> command{"solve", folder / "far.json", "--solver", "random", "--evaluations", "200",
                                         "--out", folder / "out"};
  const Outcome text = modsearch(command, folder);
  EXPECT_EQ(text.status, 1);
  EXPECT_THAT(text.out, HasSubstr("\nnearest      "));
  EXPECT_THAT(text.out, HasSubstr("\nmissed       goal 1: "));
  EXPECT_THAT(text.out, HasSubstr("m outside its tolerance: the arm is too short for it"));
  std::vector<std::string> with_json = command;
  with_json.push_back("--json");
  const json answer = json::parse(modsearch(with_json, folder).out);
  const json& nearest = answer.at("nearest");
  EXPECT_FALSE(nearest.at("design").empty());
  EXPECT_LE(nearest.at("goalError_m").get<double>(), answer.at("goalError_m").get<double>());
  const json& miss = nearest.at("misses").at(0);
  EXPECT_EQ(miss.at("goal"), "1");
  EXPECT_EQ(miss.at("why"), "proved infeasible");
  // The goal is a ball of a millimetre.
  EXPECT_NEAR(miss.at("outside_m").get<double>(), nearest.at("goalError_m").get<double>() - 0.001, 1e-9);
  // The file keeps the best by standing and score; the page shows the design that came nearest.
  EXPECT_EQ(json::parse(read_text(folder / "out/solution.json")).at("score"), answer.at("score"));
  EXPECT_THAT(read_text(folder / "out/view.html"), HasSubstr("the arm is too short for it"));
}

TEST(Solve, EndsAtTheFirstAchievedDesignWhereThatWillDo) {
  const TemporaryFolder folder;
  const Outcome solved = modsearch(
      {"solve", "seed/fixed", "--solver", "random", "--until", "achieved", "--evaluations", "100000", "--json"},
      folder);
  EXPECT_EQ(solved.status, 0) << solved.err;
  const json answer = json::parse(solved.out);
  EXPECT_EQ(answer.at("stop"), "target score");
  EXPECT_EQ(answer.at("reason"), "the first achieved design, as asked");
  EXPECT_EQ(answer.at("outcomes").at("achieved"), 1);
  EXPECT_FALSE(answer.contains("nearest"));
  EXPECT_EQ(modsearch({"solve", "seed/fixed", "--until", "tomorrow"}, folder).status, 2);
}

TEST(Solve, TellsTheFirstAchievedDesignAtOnceWhereThereIsNoBudget) {
  const TemporaryFolder folder;
  EXPECT_THAT(modsearch({"solve", "seed/fixed"}, folder).err, HasSubstr("auto: first achieved design after "));
  EXPECT_EQ(modsearch({"solve", "seed/fixed", "--evaluations", "1000"}, folder).err, "");
}

// A link of 1 m stands upright: its tip is at (0, 0, 1), 1 m from the target.
TEST(Evaluate, SaysByWhatADesignMissesTheGoal) {
  const TemporaryFolder folder;
  write(folder / "design.json", R"([{"type": "link", "parameters": {"length": 1.0}}])");
  const Outcome text = modsearch({"evaluate", "seed/fixed", folder / "design.json"}, folder);
  EXPECT_EQ(text.status, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("missed       goal 1: 999 mm outside its tolerance"));
  const json answer = json::parse(modsearch({"evaluate", "seed/fixed", folder / "design.json", "--json"}, folder).out);
  EXPECT_NEAR(answer.at("misses").at(0).at("away_m").get<double>(), 1.0, 1e-9);
}

TEST(Verify, SaysByWhatADesignMissesTheGoal) {
  const TemporaryFolder folder;
  write(folder / "far.json", far_problem().dump());
  (void)modsearch({"solve", folder / "far.json", "--solver", "random", "--evaluations", "20", "--out", folder / "out"},
                  folder);
  const Outcome text = modsearch({"verify", folder / "out/solution.json"}, folder);
  EXPECT_EQ(text.status, 1) << text.err;
  EXPECT_THAT(text.out, HasSubstr("missed       goal 1: "));
  const json answer = json::parse(modsearch({"verify", folder / "out/solution.json", "--json"}, folder).out);
  EXPECT_EQ(answer.at("misses").at(0).at("goal"), "1");
}

}  // namespace
}  // namespace modsearch
