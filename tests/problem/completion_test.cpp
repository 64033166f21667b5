#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <string>

namespace modsearch {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

Connector connector(const std::string& id, const std::string& type, Gender gender) {
  return {.id = id, .X_BC = AffinePose{Eigen::Isometry3d::Identity()}, .gender = gender, .type = type, .size = {1.0}};
}

// A module of one body with connectors of types `in` and `out`.
ModuleType module(const std::string& id, const std::string& in, const std::string& out) {
  ModuleType result;
  result.id = id;
  ModuleBody body;
  body.id = "body";
  body.connectors = {connector("in", in, Gender::kMale), connector("out", out, Gender::kFemale)};
  result.bodies = {body};
  return result;
}

RobotProblem problem_with(std::vector<ModuleType> modules, int max_modules) {
  RobotProblemSpec spec = load_problem_file("seed/fixed").spec;
  spec.library = std::make_shared<ModuleLibrary>("test", std::move(modules));
  spec.max_modules = max_modules;
  return RobotProblem{spec};
}

std::vector<int> after(const RobotProblem& problem, std::vector<int> types) { return problem.successors(types); }

// Types: 0 a link from a to a, 1 a flange from a to b, 2 a tool on b.
TEST(Successors, LeaveOnlyWhatAnEndEffectorStillFitsBehind) {
  const RobotProblem problem = problem_with(
      {module("base", "base", "a"), module("link", "a", "a"), module("flange", "a", "b"), module("tool", "b", "eef")},
      5);  // four beside the base
  EXPECT_THAT(after(problem, {}), ElementsAre(0, 1));
  EXPECT_THAT(after(problem, {0}), ElementsAre(0, 1));  // link, link, flange, tool
  EXPECT_THAT(after(problem, {0, 0}), ElementsAre(1));  // a third link would leave room for the flange alone
  EXPECT_THAT(after(problem, {0, 0, 1}), ElementsAre(2));
  EXPECT_THAT(after(problem, {0, 1}), ElementsAre(2));
  EXPECT_THAT(after(problem, {0, 0, 0}), IsEmpty());  // nothing can come of it any more
  EXPECT_THAT(after(problem, {1, 2}), IsEmpty());     // complete
}

TEST(Successors, AreNoneWhereNoDesignCanBeComplete) {
  const std::vector<ModuleType> modules{module("base", "base", "a"), module("link", "a", "a"),
                                        module("flange", "a", "b"), module("tool", "b", "eef")};
  EXPECT_THAT(after(problem_with(modules, 2), {}), IsEmpty());  // flange and tool are two
  EXPECT_THAT(after(problem_with(modules, 3), {}), ElementsAre(1));
}

TEST(Successors, OfALibraryWithoutEndEffectorsAreAllThatFit) {
  const RobotProblem problem =
      problem_with({module("base", "base", "a"), module("link", "a", "a"), module("cap", "a", "b")}, 3);
  EXPECT_THAT(after(problem, {}), ElementsAre(0, 1));
  EXPECT_THAT(after(problem, {0}), ElementsAre(0, 1));
  EXPECT_THAT(after(problem, {1}), IsEmpty());
}

TEST(Successors, RefuseModulesThatDoNotFitTogether) {
  const RobotProblem problem =
      problem_with({module("base", "base", "a"), module("flange", "a", "b"), module("tool", "b", "eef")}, 5);
  EXPECT_THROW(static_cast<void>(after(problem, {1})), std::invalid_argument);     // a tool on the base
  EXPECT_THROW(static_cast<void>(after(problem, {0, 7})), std::invalid_argument);  // no such type
}

// Whether a complete design begins with `types` and has `n` modules at most, by trying all.
bool completable(const ModuleLibrary& library, std::vector<int>& types, std::size_t n) {
  if (library.complete(types)) return true;
  if (types.size() == n) return false;
  for (const int k : library.successors(types)) {
    types.push_back(k);
    const bool found = completable(library, types, n);
    types.pop_back();
    if (found) return true;
  }
  return false;
}

// What `problem` allows after `types` and everything that it allows behind that, against the search by trial.
void expect_as_by_trial(const RobotProblem& problem, std::vector<int>& types, int& compared) {
  const auto n = static_cast<std::size_t>(problem.max_modules() - 1);
  std::vector<int> expected;
  if (types.size() < n) {
    for (const int k : problem.library().successors(types)) {
      types.push_back(k);
      if (completable(problem.library(), types, n)) expected.push_back(k);
      types.pop_back();
    }
  }
  ASSERT_EQ(problem.successors(types), expected);
  ++compared;
  for (const int k : expected) {
    types.push_back(k);
    expect_as_by_trial(problem, types, compared);
    types.pop_back();
  }
}

TEST(Successors, OfTheWorkshopAreThoseThatTryingEverythingFinds) {
  RobotProblemSpec spec = load_problem_file("seed/fixed").spec;
  spec.library = load_library("workshop");
  spec.max_modules = 5;
  const RobotProblem problem{spec};
  std::vector<int> types;
  int compared = 0;
  expect_as_by_trial(problem, types, compared);
  EXPECT_GT(compared, 500);
}

}  // namespace
}  // namespace modsearch
