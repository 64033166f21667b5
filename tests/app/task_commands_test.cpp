#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/command.hpp"
#include "places.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::modsearch;
using testing::Outcome;
using testing::read_text;
using testing::TemporaryFolder;

std::string example(const std::string& name) {
  return (test::source_folder() / "examples/tasks" / (name + ".json")).string();
}

// One file per kind of task: from the file to a solution file that verifies.
class EveryTaskFile : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Kinds, EveryTaskFile,
                         ::testing::Values("follow", "cycle", "any_order", "payload", "placed_base", "moving"),
                         [](const auto& kind) { return std::string{kind.param}; });

TEST_P(EveryTaskFile, IsSolvedWrittenAndVerified) {
  const TemporaryFolder folder;
  const Outcome solved =
      modsearch({"solve", example(GetParam()), "--evaluations", "2000", "--out", folder / "out"}, folder);
  ASSERT_EQ(solved.status, 0) << solved.out << solved.err;
  EXPECT_THAT(solved.out, HasSubstr("verified     path"));
  const std::string solution = folder / "out/solution.json";
  const Outcome verified = modsearch({"verify", solution}, folder);
  EXPECT_EQ(verified.status, 0) << verified.out << verified.err;
  const Outcome rendered = modsearch({"render", solution, "--out", folder / "page"}, folder);
  EXPECT_EQ(rendered.status, 0) << rendered.err;

  const json file = json::parse(read_text(solution));
  const json task = json::parse(read_text(example(GetParam())))["task"];
  for (const json& goal : task["goals"]) {
    EXPECT_TRUE(file["trajectory"]["goal2time"].contains(goal["ID"].get<std::string>())) << goal["ID"];
  }
}

json solution_of(const char* name, const TemporaryFolder& folder) {
  const Outcome solved = modsearch({"solve", example(name), "--evaluations", "2000", "--out", folder / "out"}, folder);
  EXPECT_EQ(solved.status, 0) << solved.out << solved.err;
  return json::parse(read_text(folder / "out/solution.json"));
}

// The verdict on a solution that was tampered with.
std::string verdict(const json& solution, const TemporaryFolder& folder) {
  const std::string file = folder / "out/solution.json";
  std::ofstream{file} << solution.dump();
  const Outcome verified = modsearch({"verify", file}, folder);
  EXPECT_NE(verified.status, 0) << verified.out;
  return verified.out + verified.err;
}

TEST(VerifyCommand, FindsAPauseThatIsTooShort) {
  const TemporaryFolder folder;
  json solution = solution_of("cycle", folder);
  for (json& t : solution["trajectory"]["t"]) t = t.get<double>() * 0.9;
  for (auto& [id, t] : solution["trajectory"]["goal2time"].items()) t = t.get<double>() * 0.9;
  EXPECT_THAT(verdict(solution, folder), HasSubstr("does not pause for goal 'grip'"));
}

TEST(VerifyCommand, FindsATrajectoryThatIsLeft) {
  const TemporaryFolder folder;
  json solution = solution_of("follow", folder);
  json& q = solution["trajectory"]["q"];
  q[q.size() - 41][0] = q[q.size() - 41][0].get<double>() + 0.01;
  EXPECT_THAT(verdict(solution, folder), HasSubstr("does not follow goal 'seam'"));
}

TEST(VerifyCommand, FindsThatTheObstacleWasNotWaitedFor) {
  const TemporaryFolder folder;
  json solution = solution_of("moving", folder);
  // Three seconds earlier the ball is still there.
  json& trajectory = solution["trajectory"];
  json t = json::array(), q = json::array();
  const json first = trajectory["q"][0];
  bool moved = false;
  double start = 0.0;
  for (std::size_t i = 0; i < trajectory["t"].size(); ++i) {
    const double time = trajectory["t"][i].get<double>();
    if (!moved && trajectory["q"][i] != first) {
      moved = true;
      start = trajectory["t"][i - 1].get<double>();
      t.push_back(0.0);
      q.push_back(first);
    }
    if (!moved) continue;
    t.push_back(time - start);
    q.push_back(trajectory["q"][i]);
  }
  ASSERT_GT(start, 1.0) << "the arm waits for the ball";
  trajectory["t"] = t;
  trajectory["q"] = q;
  trajectory["goal2time"]["1"] = t.back();
  EXPECT_THAT(verdict(solution, folder), HasSubstr("a body meets an obstacle that moves"));
}

TEST(SolveCommand, CountsWhyDesignsFailed) {
  const TemporaryFolder folder;
  const Outcome solved =
      modsearch({"solve", example("payload"), "--solver", "random", "--evaluations", "500", "--json"}, folder);
  const json outcomes = json::parse(solved.out)["outcomes"];
  std::int64_t sum = 0;
  for (const auto& [why, count] : outcomes.items()) sum += count.get<std::int64_t>();
  EXPECT_EQ(sum, 500);
  EXPECT_GT(outcomes["torque"].get<std::int64_t>(), 0);
}

}  // namespace
}  // namespace modsearch
