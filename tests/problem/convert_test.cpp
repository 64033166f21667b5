#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/convert.hpp>
#include <modsearch/problem/files.hpp>
#include <nlohmann/json.hpp>
#include <regex>

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

/// The text of `convert`, where Infinity, which Timor's files have and JSON has not, is 1e300.
json converted(const std::string& file, const ConvertOptions& options) {
  return json::parse(std::regex_replace(convert(file, options), std::regex{"\\bInfinity\\b"}, "1e300"));
}

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
  json task = problem["task"];
  task["header"].erase("notes");  // no key of CoBRA's tasks
  EXPECT_EQ(converted("seed/fixed", {.to = FileFormat::kCobra}), task);
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
  EXPECT_EQ(cobra["trajectory"]["t"], json::array()) << "the solution has no motion";
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

// The keys that CoBRA's solutions have to have, with values that depend on nothing but the solution. seed's modules
// weigh 1 kg per metre, its base nothing, and the hinge is 0.5 m and sqrt(1.25) m - 1 mm long.
TEST_F(ConvertSolution, SaysAllThatCobraAsksForTheSameEveryTime) {
  const json cobra = converted(file_, {.to = FileFormat::kCobra});
  for (const char* list : {"author", "email", "affiliation"}) EXPECT_EQ(cobra[list], json::array({""})) << list;
  EXPECT_EQ(cobra["date"], "1970-01-01");
  EXPECT_EQ(cobra["processorName"], "");
  EXPECT_EQ(cobra["moduleSet"], "seed");
  EXPECT_EQ(cobra["costFunction"], "mass");
  EXPECT_NEAR(cobra["cost"].get<double>(), 0.5 + std::sqrt(1.25) - 0.001, 1e-12);
  EXPECT_EQ(convert(file_, {.to = FileFormat::kCobra}), convert(file_, {.to = FileFormat::kCobra}));
}

TEST_F(ConvertSolution, KeepsWhatItSaysOfItsAuthors) {
  json given = json::parse(text_of(file_));
  given["author"] = {"A. Nonymous"};
  given["date"] = "2026-01-31";
  given["costFunction"] = "cyc,mass_0.5";
  given["cost"] = 3.0;
  const std::string file = folder_.write("signed.json", given.dump()).string();
  const json cobra = converted(file, {.to = FileFormat::kCobra});
  for (const char* key : {"author", "date", "costFunction", "cost"}) EXPECT_EQ(cobra[key], given[key]) << key;
  given["date"] = "yesterday";
  EXPECT_THAT(refusal(folder_.write("when.json", given.dump()).string(), {.to = FileFormat::kCobra}),
              HasSubstr("at /date: \"yesterday\" is not a date that can be written as cobra (limit: YYYY-MM-DD)"));
}

// A library is known to Timor by the folder of its modules.json.
TEST(Convert, NamesTheModulesOfASolutionByTheFolderOfTheirLibrary) {
  const TemporaryFolder folder;
  json problem = json::parse(text_of(kData / "scenarios/seed_fixed.json"));
  problem["library"] = "set_of_mine/modules.json";
  folder.write("set_of_mine/modules.json", text_of(kData / "libraries/seed.json"));
  const auto loaded = load_problem(folder.write("problem.json", problem.dump()).string());
  SolutionRecord record;
  record.problem = "problem.json";
  record.solver = "by hand";
  record.evaluation = loaded->evaluate({});
  EXPECT_EQ(json::parse(solution_to_json(*loaded, record))["moduleSet"], "set_of_mine");
}

// Timor's reader ends where a joint has no limits, where two modules share a name, and at keys that it does not know.
TEST(Convert, FillsInWhatTimorsReaderAsksOfALibrary) {
  const TemporaryFolder folder;
  json link = library_with_mesh()["modules"][1];
  link.erase("parameters");
  const json identity = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  json& body = link["bodies"][0];
  body["mass"] = 1.0;
  body["r_com"] = {0, 0, 0};
  body["notes"] = "found in the attic";
  body["collision"] = json::array();
  body.erase("visual");
  body["connectors"][1]["pose"] = identity;
  json tip = body;
  tip["ID"] = "tip";
  tip["connectors"] = json::array({body["connectors"][1]});
  body["connectors"].erase(1);
  const json last = body;
  link["bodies"] = json::array({last, tip});
  link["joints"] = json::array({{{"ID", "glue"},
                                 {"parent", last["ID"]},
                                 {"child", "tip"},
                                 {"type", "fixed"},
                                 {"poseParent", identity},
                                 {"poseChild", identity}}});
  link["header"] = {{"ID", "one"}, {"name", "link"}, {"notes", "old"}};
  json library = library_with_mesh();
  library["author"] = {"A"};
  library["modules"][1] = link;
  link["header"]["ID"] = "two";
  library["modules"].push_back(link);
  const std::string text = convert(folder.write("modules.json", library.dump()).string(), {.to = FileFormat::kTimor});
  EXPECT_THAT(text, HasSubstr("\"limits\": {\"positionLower\": -Infinity, \"positionUpper\": Infinity}"));
  EXPECT_EQ(text.find("notes"), std::string::npos);
  EXPECT_EQ(text.find("author"), std::string::npos);
  EXPECT_THAT(text, HasSubstr("\"name\": \"link\""));
  EXPECT_THAT(text, HasSubstr("\"name\": \"link two\""));
  EXPECT_EQ(load_library(folder.write("again.json", text).string())->n_types(), 2);
}

// Modules that differ in their lengths alone share a name in the library; frozen they are told apart.
TEST(Convert, TellsFrozenModulesApartByTheirNames) {
  const TemporaryFolder folder;
  const json design = {{{"type", "link"}, {"parameters", {{"length", 0.6}}}},
                       {{"type", "link"}, {"parameters", {{"length", 0.7}}}}};
  const json timor =
      converted(folder.write("design.json", design.dump()).string(), {.to = FileFormat::kTimor, .library = "seed"});
  EXPECT_EQ(timor["modules"][1]["header"]["name"], "Straight link@1");
  EXPECT_EQ(timor["modules"][2]["header"]["name"], "Straight link@2");
}

TEST(Convert, ReadsALibraryThatIsABareList) {
  const TemporaryFolder folder;
  const json library = json::parse(text_of(kData / "libraries/seed.json"));
  const std::string file = folder.write("list.json", library["modules"].dump()).string();
  EXPECT_EQ(converted(file, {})["modules"], library["modules"]);
}

TEST(Convert, SaysOfAListThatItIsNeitherDesignNorLibrary) {
  const TemporaryFolder folder;
  EXPECT_THAT(refusal(folder.write("list.json", "[[1, 2], [3]]").string(), {}),
              HasSubstr("at /0: [1,2] is not the placement of a module, a \"type\", as in a design"));
}

/// A task of CoBRA's with a mesh, and the folders real/, real/deep/ and a link to the latter that lies elsewhere.
class ConvertIntoALink : public ::testing::Test {
 protected:
  ConvertIntoALink() {
    folder_.write("parts/part.obj", "v 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\n");
    std::filesystem::create_directories(folder_.path() / "real/deep");
    std::filesystem::create_directory_symlink(folder_.path() / "real/deep", folder_.path() / "link");
    json library = library_with_mesh();
    json& body = library["modules"][1]["bodies"][0];
    body["collision"][0]["parameters"] = {{"file", "parts/part.obj"}, {"scale", 1.0}};
    body["visual"] = body["collision"];
    library_ = folder_.write("lib.json", library.dump()).string();
    json problem = json::parse(text_of(kData / "scenarios/seed_fixed.json"));
    problem["task"]["obstacles"] = {{{"ID", "part"}, {"collision", body["collision"]}}};
    task_ = folder_.write("task.json", problem["task"].dump()).string();
    problem["task"] = "task.json";
    problem["library"] = "lib.json";
    problem_ = folder_.write("problem.json", problem.dump()).string();
  }

  /// Every file that `value` names, seen from the folder that the link leads to, exists.
  void expect_all_there(const json& value) const {
    if (!value.is_structured()) return;
    for (const auto& [key, entry] : value.items()) {
      if (key == "file" || ((key == "task" || key == "library") && entry.is_string())) {
        EXPECT_TRUE(std::filesystem::exists(folder_.path() / "real/deep" / entry.get<std::string>())) << entry;
      }
      expect_all_there(entry);
    }
  }

  TemporaryFolder folder_;
  std::string library_;
  std::string task_;
  std::string problem_;
};

TEST_F(ConvertIntoALink, NamesFilesFromTheFolderThatTheLinkLeadsTo) {
  const std::filesystem::path link = folder_.path() / "link";
  for (const std::string& file : {library_, task_, problem_}) {
    SCOPED_TRACE(file);
    expect_all_there(converted(file, {.folder = link}));
  }
  expect_all_there(converted(task_, {.to = FileFormat::kCobra, .folder = link}));
  expect_all_there(converted(problem_, {.to = FileFormat::kCobra, .folder = link}));
}

TEST_F(ConvertIntoALink, NamesTheMeshesOfADesignLikewise) {
  const std::filesystem::path link = folder_.path() / "link";
  const json design = json::array({{{"type", "link"}, {"parameters", {{"length", 0.6}}}}});
  const std::string file = folder_.write("design.json", design.dump()).string();
  expect_all_there(converted(file, {.to = FileFormat::kTimor, .library = library_, .folder = link}));
  const std::string urdf = convert(file, {.to = FileFormat::kUrdf, .library = library_, .folder = link});
  EXPECT_THAT(urdf, HasSubstr("<mesh filename=\"../../parts/part.obj\""));
}

// A task package/set/one.json names its meshes from package/ on, and so does a copy in other/set/.
TEST(Convert, NamesMeshesOfATaskOfCobrasFromTheTopOfItsPackage) {
  const TemporaryFolder folder;
  json task = json::parse(text_of(kData / "scenarios/seed_fixed.json"))["task"];
  task["header"]["ID"] = "set/one";
  task["obstacles"] = {
      {{"ID", "part"}, {"collision", {{{"type", "mesh"}, {"parameters", {{"file", "assets/part.obj"}}}}}}}};
  folder.write("package/assets/part.obj", "v 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\n");
  const std::string file = folder.write("package/set/one.json", task.dump()).string();
  std::filesystem::create_directories(folder.path() / "other/set");
  const auto mesh = [&](FileFormat to, const char* out) {
    return converted(file,
                     {.to = to, .folder = folder.path() / out})["obstacles"][0]["collision"][0]["parameters"]["file"];
  };
  EXPECT_EQ(mesh(FileFormat::kCobra, "other/set"), "../package/assets/part.obj");
  EXPECT_EQ(mesh(FileFormat::kModsearch, "other/set"), "../../package/assets/part.obj");
  EXPECT_EQ(mesh(FileFormat::kCobra, "package/set"), "assets/part.obj");
}

// JSON has no word for Infinity, and empty lists would stand for the default tolerances.
TEST(Convert, WritesTolerancesThatLimitNothingWithoutInfinity) {
  const TemporaryFolder folder;
  json task = json::parse(text_of(kData / "scenarios/seed_fixed.json"))["task"];
  json& pose = task["goals"][0]["goalPose"];
  pose["toleranceProjection"] = {"x", "y"};
  pose["tolerance"] = {{-0.1, 0.1}, {-0.2, 0.2}};
  std::string text = task.dump();
  text.replace(text.find("[-0.1,0.1]"), 10, "[-Infinity,Infinity]");
  json written =
      converted(folder.write("task.json", text).string(), {.to = FileFormat::kCobra})["goals"][0]["goalPose"];
  EXPECT_EQ(written["toleranceProjection"], json::array({"y"}));
  EXPECT_EQ(written["tolerance"], json::array({{-0.2, 0.2}}));
  text.replace(text.find("[-0.2,0.2]"), 10, "[-Infinity,Infinity]");
  written = converted(folder.write("task.json", text).string(), {})["goals"][0]["goalPose"];
  EXPECT_EQ(written["toleranceProjection"], json::array({"Theta_R"})) << "at most half a turn: every rotation";
}

// What Timor's reader of tasks ends at: texts of ours beside its own keys, one frame for all tolerances, an object
// where a list is meant, a base as a bare matrix, no obstacles.
TEST(Convert, WritesATaskWithNoKeysButCobras) {
  const TemporaryFolder folder;
  json task = json::parse(text_of(kData / "scenarios/seed_fixed.json"))["task"];
  task.erase("obstacles");
  const json identity = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  task["constraints"] = {{"type", "basePlacement"}, {"pose", identity}, {"notes", "level"}};
  json& pose = task["goals"][0]["goalPose"];
  pose["toleranceProjection"] = {"x", "y"};
  pose["tolerance"] = {{-0.1, 0.1}, {-0.1, 0.1}};
  pose["toleranceFrame"] = "world";
  const json cobra = converted(folder.write("task.json", task.dump()).string(), {.to = FileFormat::kCobra});
  EXPECT_FALSE(cobra["header"].contains("notes"));
  EXPECT_EQ(cobra["obstacles"], json::array());
  EXPECT_EQ(cobra["constraints"], json::array({{{"type", "basePlacement"}, {"pose", {{"nominal", identity}}}}}));
  EXPECT_EQ(cobra["goals"][0]["goalPose"]["toleranceFrame"], (json{"world", "world"}));
  pose["toleranceFrame"] = identity;
  EXPECT_THAT(refusal(folder.write("task.json", task.dump()).string(), {.to = FileFormat::kCobra}),
              HasSubstr("at /goals/0/goalPose/toleranceFrame: a frame given as a matrix cannot be written as cobra"));
}

}  // namespace
}  // namespace modsearch
