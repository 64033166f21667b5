#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/convert.hpp>
#include <modsearch/problem/files.hpp>
#include <nlohmann/json.hpp>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using test::TemporaryFolder;
using test::text_of;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::filesystem::path kData = test::source_folder() / "data";

std::string refusal(const std::string& file, const ConvertOptions& options) {
  try {
    static_cast<void>(convert(file, options));
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

json converted(const std::string& file, const ConvertOptions& options) { return json::parse(convert(file, options)); }

/// A library of one link that is a mesh nobody has.
json library_with_mesh() {
  json library = json::parse(text_of(kData / "libraries/seed.json"));
  library["modules"].erase(2);
  library["modules"].erase(2);
  json& body = library["modules"][1]["bodies"][0];
  body["inertia"] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  body["collision"] = {{{"type", "mesh"}, {"parameters", {{"file", "meshes/link.stl"}, {"scale", 0.001}}}}};
  body["visual"] = body["collision"];
  return library;
}

TEST(Convert, GivesALibraryOfOursBackAsItIs) {
  for (const char* id : {"seed", "workshop"}) {
    const json given = json::parse(text_of(kData / "libraries" / (std::string{id} + ".json")));
    EXPECT_EQ(converted(id, {}), given);
  }
}

TEST(Convert, NamesMeshesFromTheNewFolderWithoutOpeningThem) {
  const TemporaryFolder folder;
  const std::string file = folder.write("lib/library.json", library_with_mesh().dump()).string();
  const json moved = converted(file, {.folder = folder.path() / "elsewhere/deep"});
  const json& body = moved["modules"][1]["bodies"][0];
  EXPECT_EQ(body["collision"][0]["parameters"]["file"], "../../lib/meshes/link.stl");
  EXPECT_EQ(body["visual"][0]["parameters"]["file"], "../../lib/meshes/link.stl");
}

TEST(Convert, WritesTimorsLibrariesAsTheyAre) {
  const std::filesystem::path file = test::shared_folder() / "data/timor/geometric_primitive_modules/modules.json";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no recorded files under " << test::shared_folder();
  const TemporaryFolder folder;
  for (const FileFormat to : {FileFormat::kModsearch, FileFormat::kTimor}) {
    const std::string text = convert(file.string(), {.to = to, .folder = folder.path()});
    EXPECT_EQ(text.find("Infinity") == std::string::npos, to == FileFormat::kModsearch);
    const auto before = load_library(file.string());
    const auto after = load_library(folder.write("modules.json", text).string());
    ASSERT_EQ(after->n_types(), before->n_types());
    const int j1 = *before->find("J1");
    EXPECT_EQ(after->type(j1).joints[0].joint.velocity, std::numeric_limits<double>::infinity());
    EXPECT_EQ(after->type(j1).joints[0].joint.upper, before->type(j1).joints[0].joint.upper);
  }
}

TEST(Convert, SaysWhatCannotBeWritten) {
  const TemporaryFolder folder;
  EXPECT_THAT(refusal("workshop", {.to = FileFormat::kTimor}),
              HasSubstr("module \"link_120\" has parameters, which only a design fixes"));
  EXPECT_THAT(refusal("workshop", {.to = FileFormat::kUrdf}), HasSubstr("a library cannot be written as urdf"));
  EXPECT_THAT(refusal("seed/fixed", {.to = FileFormat::kUrdf}), HasSubstr("a problem cannot be written as urdf"));
  EXPECT_THAT(refusal("seed/random_wide", {.to = FileFormat::kCobra}), HasSubstr("a sampled problem"));
  const json task = json::parse(text_of(kData / "scenarios/seed_fixed.json"))["task"];
  const std::string file = folder.write("task.json", task.dump()).string();
  EXPECT_THAT(refusal(file, {.to = FileFormat::kTimor}), HasSubstr("it holds no modules"));
  json home = task;
  home["home"] = {0.1};
  EXPECT_THAT(refusal(folder.write("home.json", home.dump()).string(), {.to = FileFormat::kCobra}),
              HasSubstr("at /home: \"home\" cannot be written as cobra"));
  EXPECT_THAT(refusal(folder.write("design.json", "[]").string(), {.to = FileFormat::kUrdf}),
              HasSubstr("names no library"));
  EXPECT_THAT(refusal(folder.write("robot.urdf", "<robot/>").string(), {}), HasSubstr("is XML"));
  EXPECT_THAT(refusal(folder.write("what.json", "{\"a\": 1}").string(), {}), HasSubstr("is no library"));
}

TEST(Convert, TakesTaskAndLibraryOutOfAProblem) {
  const json problem = json::parse(text_of(kData / "scenarios/seed_fixed.json"));
  EXPECT_EQ(converted("seed/fixed", {.to = FileFormat::kCobra}), problem["task"]);
  EXPECT_EQ(converted("seed/fixed", {}), problem);
}

TEST(Convert, NamesTheFilesOfAProblemFromItsNewFolder) {
  const TemporaryFolder folder;
  json problem = json::parse(text_of(kData / "scenarios/seed_fixed.json"));
  folder.write("a/task.json", problem["task"].dump());
  folder.write("a/modules.json", text_of(kData / "libraries/seed.json"));
  problem["task"] = "task.json";
  problem["library"] = "modules.json";
  const std::string file = folder.write("a/problem.json", problem.dump()).string();
  const std::string text = convert(file, {.folder = folder.path() / "b"});
  const auto moved = load_problem(folder.write("b/problem.json", text).string());
  EXPECT_EQ(moved->task().name(), "seed/fixed");
}

TEST(Convert, GivesTheTasksOfCobraBackAsTheyAre) {
  const std::filesystem::path file = test::shared_folder() / "data/timor/tasks/simple/PTP_1.json";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no recorded files under " << test::shared_folder();
  EXPECT_EQ(converted(file.string(), {.to = FileFormat::kCobra}), json::parse(text_of(file)));
}

/// The solution of seed/fixed by one hinge.
class ConvertSolution : public ::testing::Test {
 protected:
  ConvertSolution() {
    const auto problem = load_problem("seed/fixed");
    SolutionRecord record;
    record.problem = "seed/fixed";
    const std::vector<int> types{*problem->library().find("hinge")};
    record.design = make_design(problem->library(), types, Eigen::Vector2d{0.5, std::sqrt(1.25) - 0.001});
    record.evaluation = problem->evaluate(record.design);
    record.solver = "by hand";
    write_solution(folder_.path() / "solution.json", *problem, record);
    file_ = (folder_.path() / "solution.json").string();
  }
  TemporaryFolder folder_;
  std::string file_;
};

TEST_F(ConvertSolution, IsItselfInOurFormat) {
  EXPECT_EQ(converted(file_, {.folder = folder_.path()}), json::parse(text_of(file_)));
}

TEST_F(ConvertSolution, IsASolutionOfCobrasAboutTheModulesThatTimorGets) {
  const json cobra = converted(file_, {.to = FileFormat::kCobra});
  EXPECT_EQ(cobra["moduleOrder"], (json{"base", "hinge@1"}));
  EXPECT_EQ(cobra["taskID"], "seed/fixed");
  EXPECT_FALSE(cobra.contains("modsearch"));
  EXPECT_FALSE(cobra.contains("score"));
  const std::string modules = convert(file_, {.to = FileFormat::kTimor});
  const std::string library = folder_.write("modules.json", modules).string();
  // The assembly of CoBRA's file, put together from Timor's modules, is the arm of the design.
  const std::string assembly = folder_.write("cobra.json", cobra.dump()).string();
  const std::string from_assembly = convert(assembly, {.to = FileFormat::kUrdf, .library = library});
  const std::string from_design = convert(file_, {.to = FileFormat::kUrdf});
  const auto limits = [](const std::string& text) { return text.substr(text.find("<limit"), 40); };
  EXPECT_EQ(limits(from_assembly), limits(from_design));
  EXPECT_THAT(convert(assembly, {.library = library}), HasSubstr("hinge@1"));
}

TEST_F(ConvertSolution, IsARobotAsUrdf) {
  EXPECT_THAT(convert(file_, {.to = FileFormat::kUrdf}), HasSubstr("<robot name=\"solution\">"));
}

}  // namespace
}  // namespace modsearch
