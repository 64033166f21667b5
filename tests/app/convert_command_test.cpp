#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
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

TEST(ConvertCommand, WritesASolutionAsUrdfWhereTheNameEndsSo) {
  const TemporaryFolder folder;
  ASSERT_EQ(modsearch({"solve", "seed/fixed", "--out", folder / "out", "--quiet"}, folder).status, 0);
  const Outcome done = modsearch({"convert", folder / "out/solution.json", folder / "arm.urdf"}, folder);
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_THAT(read_text(folder / "arm.urdf"), HasSubstr("<robot name=\"solution\">"));
}

TEST(ConvertCommand, TakesTheFormatFromTheOptionAndOursOtherwise) {
  const TemporaryFolder folder;
  EXPECT_EQ(modsearch({"convert", "seed/fixed", folder / "ours.json"}, folder).status, 0);
  EXPECT_EQ(modsearch({"convert", "seed/fixed", folder / "theirs.json", "--to", "cobra"}, folder).status, 0);
  EXPECT_TRUE(json::parse(read_text(folder / "ours.json")).contains("modsearch"));
  EXPECT_FALSE(json::parse(read_text(folder / "theirs.json")).contains("modsearch"));
}

TEST(ConvertCommand, SaysInOneSentenceWhatCannotBeWrittenAndWritesNothing) {
  const TemporaryFolder folder;
  const Outcome refused = modsearch({"convert", "seed", folder / "arm.urdf"}, folder);
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("a library cannot be written as urdf: it is no single arm"));
  EXPECT_FALSE(std::filesystem::exists(folder / "arm.urdf"));
}

/// A file of `folder` with this text.
void write_text(const std::string& file, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path{file}.parent_path());
  std::ofstream{file} << text;
}

TEST(MeshRoot, IsWhereMeshesAreLookedForFirst) {
  const TemporaryFolder folder;
  ASSERT_EQ(modsearch({"convert", "seed/fixed", folder / "problem.json"}, folder).status, 0);
  json problem = json::parse(read_text(folder / "problem.json"));
  const json mesh = {{"type", "mesh"}, {"parameters", {{"file", "assets/part.obj"}}}};
  problem["task"]["obstacles"] = {{{"ID", "part"}, {"collision", {mesh}}}};
  write_text(folder / "tasks/problem.json", problem.dump());
  write_text(folder / "tasks/design.json", "[]");
  // One triangle, 7 m away from the base.
  write_text(folder / "package/assets/part.obj", "v 7 0 0\nv 8 0 0\nv 7 1 0\nf 1 2 3\n");
  const std::vector<std::string> evaluate{"evaluate", folder / "tasks/problem.json", folder / "tasks/design.json"};
  EXPECT_THAT(modsearch(evaluate, folder).err, HasSubstr("(--mesh-root says where else)"));
  std::vector<std::string> there = evaluate;
  there.insert(there.end(), {"--mesh-root", folder / "package"});
  EXPECT_EQ(modsearch(there, folder).status, 0);
  there.back() = folder / "nowhere";
  const Outcome refused = modsearch(there, folder);
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("--mesh-root "));
  // A converted file names the mesh from its own folder and needs the option no more.
  write_text(folder / "moved/design.json", "[]");
  EXPECT_EQ(modsearch({"convert", folder / "tasks/problem.json", folder / "moved/problem.json", "--mesh-root",
                       folder / "package"},
                      folder)
                .status,
            0);
  EXPECT_EQ(modsearch({"evaluate", folder / "moved/problem.json", folder / "moved/design.json"}, folder).status, 0);
}

TEST(Generate, WritesTasksAndProblemsThatAreTheSameEveryTime) {
  const TemporaryFolder folder;
  for (const char* out : {"a", "b"}) {
    const Outcome done = modsearch(
        {"generate", "whitman", "--goals", "5", "--boxes", "4", "--seed", "7", "--count", "3", "--out", folder / out},
        folder);
    EXPECT_EQ(done.status, 0) << done.err;
  }
  const json task = json::parse(read_text(folder / "a/task_002.json"));
  EXPECT_EQ(task["goals"].size(), 5U);
  EXPECT_EQ(task["obstacles"].size(), 4U);
  EXPECT_EQ(task["header"]["ID"], "whitman/5g_4o/7/2");
  EXPECT_EQ(json::parse(read_text(folder / "b/task_002.json")), task);
  EXPECT_EQ(json::parse(read_text(folder / "a/problem_002.json"))["task"], "task_002.json");
  EXPECT_FALSE(std::filesystem::exists(folder / "a/task_003.json"));
}

TEST(Generate, DrawsGoalsWithFreeEndsIfAsked) {
  const TemporaryFolder folder;
  const Outcome done = modsearch({"generate", "whitman", "--free-ends", "--count", "7", "--out", folder / "a"}, folder);
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_EQ(json::parse(read_text(folder / "a/task_006.json"))["header"]["ID"], "whitman/3g_3o_free/0/6");
}

TEST(Generate, RefusesMoreGoalsThanItsLimit) {
  const TemporaryFolder folder;
  const Outcome refused = modsearch({"generate", "whitman", "--goals", "21", "--out", folder / "a"}, folder);
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("21 goals (limit: 1 to 20)"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a"));
}

}  // namespace
}  // namespace modsearch
