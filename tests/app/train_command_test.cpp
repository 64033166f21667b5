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

TEST(TrainCommand, TrainsAPolicyThatSolves) {
  const TemporaryFolder folder;
  const Outcome trained = modsearch({"train", "seed/fixed", "--agent", "mpdqn:preset=best,episodes=90,final_episodes=1",
                                     "--seed", "3", "--json", "--out", folder / "run"},
                                    folder);
  ASSERT_EQ(trained.status, 0) << trained.err;
  const json summary = json::parse(trained.out);
  EXPECT_EQ(summary["episodes"], 90);
  EXPECT_EQ(summary["end"], "episodes");
  EXPECT_FALSE(summary["diverged"]);
  // One row per evaluation and one of names.
  const std::string log = read_text(folder / "run/training.csv");
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1 + 90 / 30);

  const Outcome solved =
      modsearch({"solve", "seed/fixed", "--solver", "policy:" + (folder / "run/policy.json"), "--json"}, folder);
  ASSERT_EQ(solved.status, 0) << solved.err;
  const json solution = json::parse(solved.out);
  EXPECT_TRUE(solution["achieved"]);
  EXPECT_GE(solution["score"], 335.0);  // one module, whatever its lengths
  EXPECT_LE(solution["evaluations"], 4);

  // The lengths of the policy's modules, solved for: no worse, and the optimum where it is the one hinge.
  const Outcome refined = modsearch({"solve", "seed/fixed", "--solver", "policy:" + (folder / "run/policy.json"),
                                     "--refine", "--json", "--out", folder / "refined"},
                                    folder);
  ASSERT_EQ(refined.status, 0) << refined.err;
  const json better = json::parse(refined.out);
  EXPECT_GE(better["score"].get<double>(), solution["score"].get<double>());
  EXPECT_NEAR(better["score"].get<double>(), 341.9148, 1e-3);
  EXPECT_THAT(better["reason"].get<std::string>(), HasSubstr("its sequence solved from 8 starts"));
  EXPECT_EQ(json::parse(read_text(folder / "refined/solution.json"))["solver"]["options"]["refine"], "true");
  EXPECT_EQ(modsearch({"verify", folder / "refined/solution.json"}, folder).status, 0);
}

TEST(TrainCommand, GoesOnFromItsCheckpointToTheSamePolicy) {
  const TemporaryFolder folder;
  const std::string agent = "pdqn:preset=best,episodes=90,final_episodes=1,evaluate_every=10";
  const auto train = [&](const std::string& name, std::vector<std::string> more) {
    std::vector<std::string> words{"train", "seed/random_narrow", "--agent", agent, "--out", folder / name};
    words.insert(words.end(), more.begin(), more.end());
    return modsearch(words, folder);
  };
  ASSERT_EQ(train("whole", {}).status, 0);
  // Ended long before: its checkpoint is the end of 90 episodes; going on does nothing and gives the same policy.
  const std::string policy = read_text(folder / "whole/policy.json");
  const Outcome resumed = train("whole", {"--resume"});
  ASSERT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_EQ(json::parse(read_text(folder / "whole/policy.json"))["weights"]["crc32c"],
            json::parse(policy)["weights"]["crc32c"]);
  // Another training must not go on from it.
  const Outcome other = train("whole", {"--resume", "--seed", "7"});
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err, HasSubstr("seed=0"));
  EXPECT_EQ(train("none", {"--resume"}).status, 2);
  // Nor may it be written over.
  EXPECT_THAT(train("whole", {}).err, HasSubstr("holds a training already"));
}

TEST(TrainCommand, EndsAtCtrlCWithACheckpointThatLeadsToTheSamePolicy) {
  const TemporaryFolder folder;
  const auto words = [&](const std::string& name) {
    return std::vector<std::string>{
        "train",      "seed/random_narrow",
        "--agent",    "mpdqn:preset=report,episodes=1500,final_episodes=1,evaluation_episodes=1",
        "--quiet",    "--out",
        folder / name};
  };
  const Outcome whole = modsearch(words("whole"), folder);
  ASSERT_EQ(whole.status, 0) << whole.err;
  std::vector<std::string> again = words("cut");
  testing::Child child{again, folder.path()};
  child.interrupt_when_there_is(folder.path() / "cut/training.csv");
  const Outcome cut = child.wait();
  EXPECT_TRUE(cut.status == 130 || cut.status == 0) << cut.err;
  again.push_back("--resume");
  ASSERT_EQ(modsearch(again, folder).status, 0);
  const auto checksum = [&](const std::string& name) {
    return json::parse(read_text(folder / (name + "/policy.json")))["weights"]["crc32c"];
  };
  EXPECT_EQ(checksum("cut"), checksum("whole"));
}

TEST(TrainCommand, SaysThatATrainingHasDivergedAndKeepsNoPolicy) {
  const TemporaryFolder folder;
  const Outcome outcome = modsearch(
      {"train", "seed/fixed", "--agent", "mpdqn:preset=best,value_rate=1e30", "--out", folder / "run"}, folder);
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("the numbers left all bounds"));
  EXPECT_FALSE(std::filesystem::exists(folder / "run/policy.json"));
  EXPECT_TRUE(std::filesystem::exists(folder / "run/training.csv"));
}

TEST(TrainCommand, RefusesWhatItDoesNotKnow) {
  const TemporaryFolder folder;
  const auto complaint = [&folder](const std::string& agent) {
    const Outcome outcome = modsearch({"train", "seed/fixed", "--agent", agent}, folder);
    EXPECT_EQ(outcome.status, 2) << agent;
    return outcome.err;
  };
  EXPECT_THAT(complaint("sarsa"), HasSubstr("agent 'sarsa' is not one of pdqn, mpdqn, spdqn, paddpg, dqn"));
  EXPECT_THAT(complaint("pdqn:preset=mine"), HasSubstr("not one of report, report-code, best"));
  EXPECT_THAT(complaint("pdqn:gama=1"), HasSubstr("no option 'gama'"));
  EXPECT_THAT(complaint("pdqn:gamma=2"), HasSubstr("gamma"));
  EXPECT_THAT(complaint("pdqn:batch"), HasSubstr("not of the form key=value"));
  EXPECT_EQ(modsearch({"solve", "seed/fixed", "--solver", "policy:/nowhere/policy.json"}, folder).status, 2);
  EXPECT_EQ(modsearch({"train", "seed/fixed", "--resume"}, folder).status, 2);
}

}  // namespace
}  // namespace modsearch
