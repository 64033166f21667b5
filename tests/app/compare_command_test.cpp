#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/command.hpp"

namespace modsearch::testing {
namespace {

using ::testing::HasSubstr;

constexpr const char* kStudy = R"({
  "modsearch": 1, "name": "tiny", "problems": [{"problem": "seed/fixed"}],
  "solvers": [{"solver": "random"}, {"solver": "per-sequence:starts=2,inner=own"},
              {"solver": "policy", "label": "agent", "train": {"agent": "mpdqn:preset=best", "episodes": 60}}],
  "seeds": {"first": 0, "count": 2}, "budget": {"evaluations": 30}
})";

class CompareCommand : public ::testing::Test {
 protected:
  CompareCommand() { std::ofstream{study_} << kStudy; }
  [[nodiscard]] Outcome compare(std::vector<std::string> options) const {
    options.insert(options.begin(), {"compare", study_});
    return modsearch(options, folder_);
  }

  TemporaryFolder folder_;
  std::string study_ = folder_ / "study.json";
};

TEST_F(CompareCommand, PrintsATableAndWritesJournalCsvAndReport) {
  const Outcome outcome = compare({"--jobs", "2", "--quiet", "--out", folder_ / "out"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("seed/fixed: 1 instance, 2 seeds"));
  EXPECT_THAT(outcome.out, HasSubstr("per-sequence:starts=2,inner=own"));
  EXPECT_TRUE(outcome.err.empty()) << outcome.err;
  const std::string journal = read_text(folder_ / "out/events.jsonl");
  EXPECT_THAT(journal, HasSubstr("\"command\":\"modsearch compare"));
  const std::string runs = read_text(folder_ / "out/runs.csv");
  EXPECT_EQ(std::count(runs.begin(), runs.end(), '\n'), 1 + 1 + 3 * 2);  // header, training, runs
  EXPECT_THAT(read_text(folder_ / "out/traces.csv"), HasSubstr("cell,problem,"));
  EXPECT_THAT(read_text(folder_ / "out/report.html"), HasSubstr("per-sequence:starts=2,inner=own"));
}

TEST_F(CompareCommand, TellsTheSameInJson) {
  const Outcome outcome = compare({"--quiet", "--json", "--out", folder_ / "out"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["ended"], 7);
  const nlohmann::json& agent = json["problems"][0]["solvers"][2];
  EXPECT_EQ(agent["solver"], "agent");
  EXPECT_EQ(agent["runs"], 2);
  EXPECT_GT(agent["trainingSeconds"].get<double>(), 0.0);
}

TEST_F(CompareCommand, CountsWhyRunsEndedWithoutAnArm) {
  std::ofstream{study_} << R"({
    "modsearch": 1, "name": "hard", "seeds": {"first": 0, "count": 2}, "budget": {"evaluations": 5},
    "problems": [{"problem": "whitman/3g_3o", "instances": {"seed": 0, "count": 2}}],
    "solvers": [{"solver": "random"}]
  })";
  const Outcome outcome = compare({"--quiet", "--json", "--out", folder_ / "out"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json row = nlohmann::json::parse(outcome.out)["problems"][0]["solvers"][0];
  int sum = row["achieved"];
  EXPECT_LT(sum, 4);  // five random arms do not meet three full poses among boxes
  for (const auto& [reason, n] : row["failures"].items()) sum += n.get<int>();
  EXPECT_EQ(sum, 4);
  EXPECT_THAT(compare({"--quiet", "--resume", "--out", folder_ / "out"}).out, HasSubstr("   not achieved: "));
}

TEST_F(CompareCommand, RefusesAFolderWithAJournalUnlessItResumes) {
  ASSERT_EQ(compare({"--quiet", "--out", folder_ / "out"}).status, 0);
  const Outcome again = compare({"--quiet", "--out", folder_ / "out"});
  EXPECT_EQ(again.status, 2);
  EXPECT_THAT(again.err, HasSubstr("is there already"));
  EXPECT_EQ(compare({"--quiet", "--resume", "--recheck", "3", "--out", folder_ / "out"}).status, 0);
}

TEST_F(CompareCommand, GoesOnAfterCtrlC) {
  std::string text = kStudy;  // with a training of a second
  std::ofstream{study_} << text.replace(text.find("\"episodes\": 60"), 14, "\"episodes\": 600");
  const std::string out = folder_ / "out";
  const Child child{{"compare", study_, "--quiet", "--out", out}, folder_.path()};
  child.interrupt_when_there_is(out + "/events.jsonl");
  EXPECT_EQ(child.wait().status, 130);
  const Outcome resumed = compare({"--quiet", "--json", "--resume", "--out", out});
  ASSERT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_EQ(nlohmann::json::parse(resumed.out)["ended"], 7);
}

TEST_F(CompareCommand, NamesWhatIsWrongInTheStudy) {
  std::string text = kStudy;
  std::ofstream{study_} << text.replace(text.find("random"), 6, "randon");
  const Outcome outcome = compare({"--out", folder_ / "out"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("study.json: at /solvers/0/solver: solver 'randon' is not one of"));
}

TEST_F(CompareCommand, ListsTheStudies) {
  const Outcome outcome = modsearch({"list", "studies"}, folder_);
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.out, HasSubstr("quick"));
}

}  // namespace
}  // namespace modsearch::testing
