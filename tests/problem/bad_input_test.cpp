#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using test::TemporaryFolder;
using test::text_of;
using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

const std::filesystem::path kData = test::source_folder() / "data";
const std::string kProblem = text_of(kData / "scenarios/seed_random_obstacles.json");
const std::string kLibrary = text_of(kData / "libraries/seed.json");

void read_problem(const std::filesystem::path& file) { static_cast<void>(load_problem(file.string())); }
void read_library(const std::filesystem::path& file) { static_cast<void>(load_library(file.string())); }
void read_task(const std::filesystem::path& file) { static_cast<void>(load_task(file)); }
void read_design(const std::filesystem::path& file) { static_cast<void>(load_design(file, *load_library("seed"))); }
void read_solution(const std::filesystem::path& file) { static_cast<void>(load_solution(file)); }

using Reader = void (*)(const std::filesystem::path&);

/// The sentence with which `read` refuses `file`; it must begin with the file's name.
std::string refusal(Reader read, const std::filesystem::path& file) {
  try {
    read(file);
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr(file.string()));
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    return error.what();
  }
  ADD_FAILURE() << file << " was not refused";
  return "";
}

struct Bad {
  const char* name;
  Reader read;
  std::string text;
  std::vector<std::string> parts;  // of the sentence: place, value, limit
};

void PrintTo(const Bad& bad, std::ostream* stream) { *stream << bad.name; }

std::string with(const std::string& text, const char* pointer, const json& value) {
  json document = json::parse(text);
  document[json::json_pointer(pointer)] = value;
  return document.dump();
}

std::string without(const std::string& text, const char* pointer) {
  json document = json::parse(text);
  const json::json_pointer place{pointer};
  json& parent = document[place.parent_pointer()];
  if (parent.is_array()) {
    parent.erase(std::stoul(place.back()));
  } else {
    parent.erase(place.back());
  }
  return document.dump();
}

/// The task of the scenario, which has one goal and three obstacles.
std::string task() { return json::parse(kProblem)["task"].dump(); }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t found = text.find(from);
  EXPECT_NE(found, std::string::npos) << from;
  return text.replace(found, from.size(), to);
}

std::string repeated(const std::string& text, int n) {
  std::string result;
  for (int i = 0; i < n; ++i) result += text;
  return result;
}

class BadFile : public ::testing::TestWithParam<Bad> {};

TEST_P(BadFile, IsRefusedInOneSentence) {
  const TemporaryFolder folder;
  const std::string what = refusal(GetParam().read, folder.write("broken.json", GetParam().text));
  for (const std::string& part : GetParam().parts) EXPECT_THAT(what, HasSubstr(part));
}

constexpr char kGoal[] = "/goals/0/goalPose";

std::vector<Bad> not_json() {
  return {
      {"Empty", read_problem, "", {"is empty"}},
      {"Blank", read_problem, " \n\t ", {"is empty"}},
      {"Truncated", read_problem, kProblem.substr(0, kProblem.size() / 2), {"line 37, column 18", "ends too early"}},
      {"TruncatedInAText", read_problem, "{\"modsearch", {"line 1, column 12", "ends too early"}},
      {"MissingComma", read_problem, "{\n  \"modsearch\": 1\n  \"task\": 2\n}", {"line 3, column 8", "expected '}'"}},
      {"TrailingComma", read_problem, "{\"modsearch\": 1,}", {"line 1, column 17", "unexpected '}'"}},
      {"TwoDocuments", read_problem, "{} {}", {"line 1, column 4"}},
      {"Comment", read_problem, "// hello\n{}", {"line 1, column 1"}},
      {"SingleQuotes", read_problem, "{'modsearch': 1}", {"line 1, column 2"}},
      {"NotANumber", read_problem, replaced(kProblem, "\"r\": 0.3", "\"r\": NaN"), {"NaN is not a number", "line "}},
      {"BareInfinity",
       read_problem,
       replaced(kProblem, "\"r\": 0.3", "\"r\": Infinity"),
       {"/task/obstacles/0/collision/0/parameters/r", "Infinity is not a finite number"}},
      {"MinusInfinity",
       read_problem,
       replaced(kProblem, "\"r\": 0.3", "\"r\": -Infinity"),
       {"/parameters/r", "-Infinity is not a finite number"}},
      {"HugeNumber",
       read_problem,
       replaced(kProblem, "\"r\": 0.3", "\"r\": 1e999"),
       {"1e999", "too large (limit: 1.8e308)", "line "}},
      {"HugeNegativeNumber", read_problem, replaced(kProblem, "\"r\": 0.3", "\"r\": -1e999"), {"-1e999", "too large"}},
      {"LeadingZero", read_problem, replaced(kProblem, "\"r\": 0.3", "\"r\": 00.3"), {"line "}},
      {"DuplicateKey",
       read_problem,
       replaced(kProblem, "\"maxModules\": 10", "\"maxModules\": 10, \"maxModules\": 11"),
       {"at the top level: key \"maxModules\" occurs twice"}},
      {"DuplicateKeyDeepInside",
       read_problem,
       replaced(kProblem, "{\"r\": 0.2}", "{\"r\": 0.2, \"r\": 0.2}"),
       {"at /task/obstacles/1/collision/0/parameters: key \"r\" occurs twice"}},
      {"DeepArrays", read_problem, std::string(200'000, '['), {"line 1, column 65", "limit 64"}},
      {"DeepArraysClosed", read_problem, std::string(100'000, '[') + std::string(100'000, ']'), {"limit 64"}},
      {"DeepObjects", read_problem, repeated("{\"a\":", 200'000), {"limit 64"}},
      {"InvalidUtf8", read_problem, replaced(kProblem, "large sphere", "large \xC3\x28 sphere"), {"line "}},
      {"Utf16", read_problem, std::string("\xFF\xFE{\0}\0", 6), {"UTF-16"}},
      {"Binary", read_problem, std::string("\x00\x01\x02\x03", 4), {"line 1, column 1"}},
      {"NulInAText", read_problem, "{\"modsearch\\u0000\": 1}", {"U+0000", "line 1"}},
      {"ControlCharacter", read_problem, "{\"mod\nsearch\": 1}", {"line "}},
      {"OnlyANumber", read_problem, "3", {"at the top level: 3 is not an object"}},
      {"AList", read_problem, "[]", {"at the top level: [] is not an object"}},
      {"Null", read_problem, "null", {"at the top level: null is not an object"}},
  };
}

std::vector<Bad> bad_problems() {
  return {
      {"UnknownKey", read_problem, with(kProblem, "/tsak", 1), {"at the top level: key \"tsak\" is not known here"}},
      {"NewerVersion", read_problem, with(kProblem, "/modsearch", 2), {"at /modsearch: 2 is not an integer in [1, 1]"}},
      {"NoTask", read_problem, without(kProblem, "/task"), {"at the top level: key \"task\" is missing"}},
      {"NoLibrary", read_problem, without(kProblem, "/library"), {"key \"library\" is missing"}},
      {"NoScoring", read_problem, without(kProblem, "/scoring"), {"key \"scoring\" is missing"}},
      {"LostTask", read_problem, with(kProblem, "/task", "lost.json"), {" -> ", "lost.json: there is no such file"}},
      {"LostLibrary",
       read_problem,
       with(kProblem, "/library", "lost.json"),
       {" -> ", "lost.json: there is no such file"}},
      {"TooManyModules",
       read_problem,
       with(kProblem, "/maxModules", 65),
       {"at /maxModules: 65 is not an integer in [1, 64]"}},
      {"NoModules", read_problem, with(kProblem, "/maxModules", 0), {"at /maxModules: 0 is not an integer in [1, 64]"}},
      {"HalfAModule", read_problem, with(kProblem, "/maxModules", 2.5), {"at /maxModules: 2.5 is not an integer"}},
      {"ModulesInWords",
       read_problem,
       with(kProblem, "/maxModules", "ten"),
       {"at /maxModules: \"ten\" is not an integer"}},
      {"UnknownLevel",
       read_problem,
       with(kProblem, "/collision", "sideways"),
       {"at /collision: \"sideways\" is not one of \"none\""}},
      {"UnknownScoring",
       read_problem,
       with(kProblem, "/scoring/type", "beauty"),
       {"at /scoring/type: \"beauty\" is not one of"}},
      {"NegativeWeight",
       read_problem,
       with(kProblem, "/scoring", {{"type", "weighted"}, {"mass", -1}}),
       {"at /scoring/mass: -1 is not at least 0"}},
      {"WeightsForAlgorithm1",
       read_problem,
       with(kProblem, "/scoring/mass", 3),
       {"at /scoring: key \"mass\" is not known here"}},
      {"UnknownSampledGoal",
       read_problem,
       with(kProblem, "/sampling/goal", "9"),
       {"at /sampling/goal: \"9\" is not the ID of a goal"}},
      {"ReversedBox",
       read_problem,
       with(kProblem, "/sampling/box/upper", {1, 1, 0.5}),
       {"at /sampling/box/upper/2: 0.5 is not at least 1"}},
      {"FlatBox",
       read_problem,
       with(kProblem, "/sampling/box/lower", {0, 0}),
       {"at /sampling/box/lower: [0,0] is not a list of 3"}},
      {"NoGoals",
       read_problem,
       without(with(kProblem, "/task/goals", json::array()), "/sampling"),
       {"at /task: the task has no goals"}},
      {"ListedTask", read_problem, with(kProblem, "/task", json::array()), {"at /task: [] is not an object"}},
  };
}

std::vector<Bad> bad_tasks() {
  const auto pose = [](const char* key) { return std::string(kGoal) + key; };
  const std::string nominal = pose("/nominal");
  const std::string tolerance = pose("/tolerance");
  return {
      {"UnknownGoalType",
       read_task,
       with(task(), "/goals/0/type", "dance"),
       {"at /goals/0/type: \"dance\" is not one of \"at\", \"reach\""}},
      {"GoalWithoutPose", read_task, without(task(), kGoal), {"at /goals/0: key \"goalPose\" is missing"}},
      {"GoalTwice",
       read_task,
       with(task(), "/goals/1", json::parse(task())["goals"][0]),
       {"at /goals/1/ID: \"1\" is not a new ID"}},
      {"Shear",
       read_task,
       with(task(), (nominal + "/0/1").c_str(), 0.01),
       {"at /goals/0/goalPose/nominal", "not a rotation (limit: within 1e-6)"}},
      {"Mirror", read_task, with(task(), (nominal + "/2/2").c_str(), -1), {"not a rotation"}},
      {"LastRow",
       read_task,
       with(task(), (nominal + "/3/3").c_str(), 2),
       {"at /goals/0/goalPose/nominal/3: [0,0,0,2] is not [0, 0, 0, 1]"}},
      {"ThreeRows",
       read_task,
       without(task(), (nominal + "/3").c_str()),
       {"at /goals/0/goalPose/nominal: ", "is not a list of 4"}},
      {"ReversedInterval",
       read_task,
       with(task(), (tolerance + "/0").c_str(), {0.2, 0.1}),
       {"at /goals/0/goalPose/tolerance/0/1: 0.1 is not at least 0.2"}},
      {"OneEndOnly",
       read_task,
       with(task(), (tolerance + "/0").c_str(), {0.2}),
       {"at /goals/0/goalPose/tolerance/0: [0.2] is not a list of 2"}},
      {"UnknownProjection",
       read_task,
       with(task(), pose("/toleranceProjection/0").c_str(), "r_cube"),
       {"at /goals/0/goalPose/toleranceProjection/0: \"r_cube\" is not one of"}},
      {"MoreProjectionsThanIntervals",
       read_task,
       with(task(), pose("/toleranceProjection/1").c_str(), "x"),
       {"at /goals/0/goalPose/tolerance: has 1 intervals for 2 projections"}},
      {"UnknownFrame",
       read_task,
       with(task(), pose("/toleranceFrame").c_str(), "moon"),
       {"at /goals/0/goalPose/toleranceFrame: \"moon\" is not the name of a frame (known here: world)"}},
      {"MotionWithoutTimes",
       read_task,
       with(task(), "/obstacles/0/motion", json::object()),
       {"at /obstacles/0/motion: key \"t\" is missing"}},
      {"MotionOfTwoTimesAndNoPose",
       read_task,
       with(task(), "/obstacles/0/motion", {{"t", {0, 1}}, {"pose", json::array()}}),
       {"at /obstacles/0: ", "motion: 2 times for 0 poses"}},
      {"UnknownShape",
       read_task,
       with(task(), "/obstacles/0/collision/0/type", "teapot"),
       {"at /obstacles/0/collision/0/type: \"teapot\" is not one of"}},
      {"NegativeRadius",
       read_task,
       with(task(), "/obstacles/0/collision/0/parameters/r", -0.3),
       {"at /obstacles/0/collision/0/parameters/r: -0.3 is not at least 0"}},
      {"SizeInWords",
       read_task,
       with(task(), "/obstacles/0/collision/0/parameters/r", "0.3"),
       {"at /obstacles/0/collision/0/parameters/r: \"0.3\" is not a number"}},
      {"SphereWithHeight",
       read_task,
       with(task(), "/obstacles/0/collision/0/parameters/z", 1),
       {"at /obstacles/0/collision/0/parameters: key \"z\" is not known here (known: \"r\")"}},
      {"MissingMesh",
       read_task,
       with(task(), "/obstacles/0/collision/0", {{"type", "mesh"}, {"parameters", {{"file", "lost.stl"}}}}),
       {"at /obstacles/0/collision/0/parameters/file: mesh \"lost.stl\"", "is missing"}},
      {"EmptyMeshScale",
       read_task,
       with(task(), "/obstacles/0/collision/0",
            {{"type", "mesh"}, {"parameters", {{"file", "lost.stl"}, {"scale", 0}}}}),
       {"at /obstacles/0/collision/0/parameters/scale: 0 is not above 0"}},
      {"UnknownConstraint",
       read_task,
       with(task(), "/constraints/0/type", "beQuiet"),
       {"at /constraints/0/type: \"beQuiet\" is not one of"}},
      {"EndEffectorConstraint",
       read_task,
       with(task(), "/constraints/0", {{"type", "endEffector"}, {"v_max", 0.1}}),
       {"at /constraints/0/v_max: a limit of the end effector's speed along the motion is not supported yet"}},
      {"BaseWithTolerance",
       read_task,
       with(task(), "/constraints/2/pose/tolerance", json::array()),
       {"at /constraints/2/pose: key \"toleranceProjection\" is missing"}},
      {"BaseOnACircle",
       read_task,
       with(with(task(), "/constraints/2/pose/tolerance", {{0, 1}}), "/constraints/2/pose/toleranceProjection",
            {"r_cyl"}),
       {"at /constraints/2/pose/toleranceProjection/0: \"r_cyl\" is not one of \"x\""}},
      {"OrderOfAnUnknownGoal",
       read_task,
       with(task(), "/constraints/0", {{"type", "allGoalsFulfilledInOrder"}, {"order", {"1", "7"}}}),
       {"at /constraints/0/order/1: \"7\" is not the ID of a goal"}},
      {"OrderTwice",
       read_task,
       with(task(), "/constraints/0", {{"type", "allGoalsFulfilledInOrder"}, {"order", {"1", "1"}}}),
       {"at /constraints/0/order/1: \"1\" is not named once only"}},
      {"ForceInThePlane",
       read_task,
       with(task(), "/goals/0/externalForce", {0, 1}),
       {"at /goals/0/externalForce: [0,1] is not a list of 3"}},
      {"PayloadThatLifts", read_task, with(task(), "/payload", -1), {"at /payload: -1 is not at least 0"}},
      {"PauseWithoutEnd",
       read_task,
       with(task(), "/goals/1", {{"ID", "p"}, {"type", "pause"}}),
       {"at /goals/1: key \"duration\" is missing"}},
      {"ReturnToNobody",
       read_task,
       with(task(), "/goals/1", {{"ID", "r"}, {"type", "returnTo"}, {"returnToGoal", "9"}}),
       {"at /goals/1/returnToGoal: \"9\" is not the ID of a goal with a pose"}},
      {"TrajectoryOfNoPose",
       read_task,
       with(task(), "/goals/1", {{"ID", "f"}, {"type", "follow"}, {"trajectory", {{"pose", json::array()}}}}),
       {"at /goals/1: trajectory 'f': 0 poses and 8 knots, at least 2 of each are needed"}},
      {"NoTimeStep", read_task, with(task(), "/header/timeStepSize", 0), {"at /header/timeStepSize: 0 is not above 0"}},
      {"HomeOfWords", read_task, with(task(), "/home", {"up"}), {"at /home/0: \"up\" is not a number"}},
      {"Objects", read_task, with(task(), "/objects", {1}), {"at /objects: \"objects\" may only be empty"}},
      {"UnknownKeyInHeader",
       read_task,
       with(task(), "/header/colour", "red"),
       {"at /header: key \"colour\" is not known here"}},
      {"NamedParameter",
       read_task,
       with(task(), "/obstacles/0/collision/0/parameters/r", {{"parameter", "length"}}),
       {"\"length\" is not a parameter of this module (known: none)"}},
  };
}

std::vector<Bad> bad_libraries() {
  const char* const joint = "/modules/2/joints/0";
  const auto of_joint = [&](const char* key) { return std::string(joint) + key; };
  return {
      {"NoModulesKey", read_library, "{}", {"at the top level: key \"modules\" is missing"}},
      {"NoBase",
       read_library,
       without(kLibrary, "/modules/0"),
       {"at /modules: ", "no module has a connector of type 'base'"}},
      {"SameIdTwice",
       read_library,
       with(kLibrary, "/modules/2/header/ID", "link"),
       {"at /modules/2/header/ID: \"link\" is not a new ID"}},
      {"UnknownKeyInModule",
       read_library,
       with(kLibrary, "/modules/1/bodys", 1),
       {"at /modules/1: key \"bodys\" is not known here"}},
      {"ReversedParameter",
       read_library,
       with(kLibrary, "/modules/1/parameters/0/upper", 0.1),
       {"at /modules/1/parameters/0/upper: 0.1 is not at least 0.5"}},
      {"ParameterInFeet",
       read_library,
       with(kLibrary, "/modules/1/parameters/0/unit", "ft"),
       {"at /modules/1/parameters/0/unit: \"ft\" is not one of \"m\", \"rad\""}},
      {"AngleAsLength",
       read_library,
       with(kLibrary, "/modules/1/parameters/0/unit", "rad"),
       {"at /modules/1/bodies/0/mass/parameter: \"length\" is not a length"}},
      {"UnknownParameter",
       read_library,
       with(kLibrary, "/modules/1/bodies/0/mass/parameter", "width"),
       {"at /modules/1/bodies/0/mass/parameter: \"width\" is not a parameter of this module (known: length)"}},
      {"MassThatTurnsNegative",
       read_library,
       with(kLibrary, "/modules/1/bodies/0/mass/offset", -1),
       {"at /modules/1/bodies/0/mass: ", "becomes -0.5", "limit: at least 0"}},
      {"NegativeMass",
       read_library,
       with(kLibrary, "/modules/1/bodies/0/mass", -1),
       {"at /modules/1/bodies/0/mass: -1 is not at least 0"}},
      {"UnknownGender",
       read_library,
       with(kLibrary, "/modules/1/bodies/0/connectors/0/gender", "x"),
       {"at /modules/1/bodies/0/connectors/0/gender: \"x\" is not one of \"f\", \"m\", \"h\""}},
      {"ThreeConnectors",
       read_library,
       with(kLibrary, "/modules/1/bodies/0/connectors/2",
            json::parse(kLibrary)["modules"][1]["bodies"][0]["connectors"][0]),
       {"at /modules: module 'link': has 3 connectors"}},
      {"JointToNowhere",
       read_library,
       with(kLibrary, of_joint("/child").c_str(), "moon"),
       {"at /modules/2/joints/0/child: \"moon\" is not the ID of a body"}},
      {"JointToItself",
       read_library,
       with(kLibrary, of_joint("/child").c_str(), "proximal"),
       {"at /modules/2/joints/0/child: \"proximal\" is not another body"}},
      {"ReversedLimits",
       read_library,
       with(kLibrary, of_joint("/limits/positionUpper").c_str(), -4),
       {"at /modules/2/joints/0/limits/positionUpper: -4 is not at least -3.14"}},
      {"EndlessRevoluteJoint",
       read_library,
       replaced(kLibrary, "\"positionUpper\": 3.141592653589793", "\"positionUpper\": Infinity"),
       {"/limits/positionUpper: Infinity is not a finite limit"}},
      {"PassiveJoint",
       read_library,
       with(kLibrary, of_joint("/passive").c_str(), true),
       {"at /modules/2/joints/0/passive: passive joints are not supported yet"}},
      {"PassiveInWords",
       read_library,
       with(kLibrary, of_joint("/passive").c_str(), "no"),
       {"at /modules/2/joints/0/passive: \"no\" is not true or false"}},
      {"SphericalJoint",
       read_library,
       with(kLibrary, of_joint("/type").c_str(), "spherical"),
       {"at /modules/2/joints/0/type: \"spherical\" is not one of"}},
      {"InertiaInWords",
       read_library,
       with(kLibrary, "/modules/1/bodies/0/inertia", "heavy"),
       {"at /modules/1/bodies/0/inertia: \"heavy\" is not \"uniform\""}},
      {"UniformInertiaOfNothing",
       read_library,
       with(kLibrary, "/modules/0/bodies/0/inertia", "uniform"),
       {"at /modules/0/bodies/0/inertia: \"uniform\" needs collision geometry"}},
      {"UnknownRule",
       read_library,
       with(kLibrary, "/ignore_collisions", "all"),
       {"at /ignore_collisions: \"all\" is not one of \"rigid\""}},
      {"LooseBody",
       read_library,
       with(kLibrary, "/modules/2/joints", json::array()),
       {"module 'hinge': 0 joints between 2 bodies"}},
      {"MatrixWithAText",
       read_library,
       with(kLibrary, "/modules/1/bodies/0/connectors/0/pose/0/0", "one"),
       {"at /modules/1/bodies/0/connectors/0/pose/0/0: \"one\" is not a number"}},
      {"ParameterInARotation",
       read_library,
       with(kLibrary, "/modules/1/bodies/0/connectors/0/pose/0/0", {{"parameter", "length"}}),
       {"at /modules/1/bodies/0/connectors/0/pose/0/0: ", "is not a number"}},
  };
}

std::vector<Bad> bad_designs() {
  return {
      {"DesignOfAnUnknownModule",
       read_design,
       R"([{"type": "snake", "parameters": {}}])",
       {"at /0/type: \"snake\" is not a module of library 'seed' (known: link, hinge, rotary)"}},
      {"DesignTooLong",
       read_design,
       R"([{"type": "link", "parameters": {"length": 1.6}}])",
       {"at /0/parameters/length: 1.6 is not in [0.5, 1.5]"}},
      {"DesignWithoutALength",
       read_design,
       R"([{"type": "hinge", "parameters": {"proximal": 1}}])",
       {"at /0/parameters: key \"distal\" is missing"}},
      {"DesignWithoutParameters", read_design, R"([{"type": "hinge"}])", {"at /0: key \"parameters\" is missing"}},
      {"DesignWithAnExtraLength",
       read_design,
       R"([{"type": "link", "parameters": {"length": 1, "width": 1}}])",
       {"at /0/parameters/width: module \"link\" has no such parameter"}},
      {"DesignAsText", read_design, R"("hinge")", {"at the top level: \"hinge\" is not a design"}},
      {"SolutionOfNothing", read_solution, "{}", {"at the top level: key \"problem\" is missing"}},
      {"SolutionOfItself",
       read_solution,
       R"({"modsearch": 1, "problem": "broken.json"})",
       {"at /problem: \"broken.json\" cannot be used"}},
  };
}

std::string name_of(const ::testing::TestParamInfo<Bad>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(NotJson, BadFile, ::testing::ValuesIn(not_json()), name_of);
INSTANTIATE_TEST_SUITE_P(Problem, BadFile, ::testing::ValuesIn(bad_problems()), name_of);
INSTANTIATE_TEST_SUITE_P(Task, BadFile, ::testing::ValuesIn(bad_tasks()), name_of);
INSTANTIATE_TEST_SUITE_P(Library, BadFile, ::testing::ValuesIn(bad_libraries()), name_of);
INSTANTIATE_TEST_SUITE_P(Design, BadFile, ::testing::ValuesIn(bad_designs()), name_of);

TEST(UnreadableFile, IsRefusedByItsKind) {
  const TemporaryFolder folder;
  EXPECT_THAT(refusal(read_problem, folder.path()), EndsWith("is a directory, not a file"));
  EXPECT_THAT(refusal(read_problem, folder.path() / "lost.json"), HasSubstr("there is no such file"));
  EXPECT_THAT(refusal(read_problem, "/dev/null"), EndsWith("is not a regular file"));
  const auto within_a_file = folder.write("file", "{}") / "inside.json";
  EXPECT_THAT(refusal(read_problem, within_a_file), HasSubstr("inside.json"));
}

TEST(UnreadableFile, IsRefusedWithoutPermission) {
  const TemporaryFolder folder;
  const auto file = folder.write("secret.json", kProblem);
  std::filesystem::permissions(file, std::filesystem::perms::none);
  if (std::ifstream{file}) GTEST_SKIP() << "this user may read everything";
  EXPECT_THAT(refusal(read_problem, file), HasSubstr("cannot be opened: "));
}

TEST(UnreadableFile, IsRefusedWhereItIsTooLargeWithoutBeingRead) {
  const TemporaryFolder folder;
  const auto file = folder.write("large.json", "");
  std::filesystem::resize_file(file, 1ULL << 32U);  // sparse: takes no space
  EXPECT_THAT(refusal(read_problem, file), AllOf(HasSubstr("has 4294967296 bytes"), HasSubstr("limit 67108864")));
}

TEST(UnreadableFile, MayBeAMesh) {
  const TemporaryFolder folder;
  json broken = json::parse(task());
  broken["obstacles"][0]["collision"] = {{{"type", "mesh"}, {"parameters", {{"file", "broken.stl"}}}}};
  const auto file = folder.write("task.json", broken.dump());
  for (const std::string& text :
       {std::string{}, std::string{"solid nothing\nendsolid nothing\n"}, std::string(200, 'x'),
        std::string("solid a\nfacet normal 0 0 1\nouter loop\nvertex nan 0 0\n")}) {
    folder.write("broken.stl", text);
    EXPECT_THAT(refusal(read_task, file),
                HasSubstr("at /obstacles/0/collision/0/parameters/file: mesh \"broken.stl\""));
  }
  broken["obstacles"][0]["collision"][0]["parameters"]["file"] = "mesh.exe";
  folder.write("mesh.exe", "MZ");
  EXPECT_THAT(refusal(read_task, folder.write("task.json", broken.dump())), HasSubstr("not supported yet (\".exe\")"));
}

// Whatever happens to a good file, it is read or refused with a FileError, never anything else.
void expect_only_file_errors(const std::string& good, Reader read, unsigned seed, int rounds) {
  const TemporaryFolder folder;
  std::mt19937 generator{seed};
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(generator()) % n; };
  const std::string alphabet = "{}[]\",:0123456789.eE+-\\u \n\tnaInftyrls\x80\xC3\xFF";
  for (int round = 0; round < rounds; ++round) {
    std::string text = good;
    const std::size_t edits = 1 + below(4);
    for (std::size_t i = 0; i < edits; ++i) {
      const std::size_t at = below(text.size());
      switch (below(5)) {
        case 0:
          text[at] = alphabet[below(alphabet.size())];
          break;
        case 1:
          text.insert(at, 1, alphabet[below(alphabet.size())]);
          break;
        case 2:
          text.erase(at, 1 + below(20));
          break;
        case 3:
          text[at] = static_cast<char>(below(256));
          break;
        default:
          text.insert(at, text.substr(below(text.size()), 1 + below(30)));
      }
    }
    if (below(20) == 0) text.resize(below(text.size()));
    const auto file = folder.write("mutant.json", text);
    try {
      read(file);
    } catch (const FileError&) {
    } catch (const std::exception& error) {
      FAIL() << "round " << round << ": " << error.what() << "\n" << text;
    }
  }
}

TEST(MutatedFile, IsReadOrRefused) {
  expect_only_file_errors(json::parse(kProblem).dump(), read_problem, 1, 1000);
  expect_only_file_errors(json::parse(kLibrary).dump(), read_library, 2, 1000);
  expect_only_file_errors(task(), read_task, 3, 1000);
}

TEST(MutatedFile, IsReadOrRefusedAsASolutionToo) {
  const auto problem = load_problem("seed/fixed");
  SolutionRecord record;
  record.problem = "seed/fixed";
  const std::vector<int> types{1};
  record.design = make_design(problem->library(), types, Eigen::Vector2d{0.5, 1.0});
  record.evaluation = problem->evaluate(record.design);
  Path path{Eigen::MatrixXd::Zero(2, 2)};
  path.waypoints.row(1) = record.evaluation.attempt.postures.row(0);
  record.evaluation.attempt.path = path;
  record.evaluation.attempt.goal_waypoints = {1};
  expect_only_file_errors(json::parse(solution_to_json(*problem, record)).dump(), read_solution, 4, 500);
}

}  // namespace
}  // namespace modsearch
