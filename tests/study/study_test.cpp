#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/study/study.hpp>
#include <modsearch/study/text_hash.hpp>
#include <set>
#include <stdexcept>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using ::testing::HasSubstr;

Study study_of_two() {
  return {.name = "two",
          .problems = {study_problem("seed/random_narrow", InstanceRange{.seed = 4, .first = 10, .count = 2})},
          .solvers = {{.label = "a", .text = "random", .solver = std::make_shared<RandomSearch>()},
                      {.label = "b", .text = "other", .solver = std::make_shared<RandomSearch>()}},
          .seeds = {5, 6},
          .budget = {.evaluations = 10}};
}

std::string refusal(const Study& study) {
  try {
    static_cast<void>(cells_of(study));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "none";
}

// Landon Curt Noll's table of test vectors (isthe.com/chongo/tech/comp/fnv).
TEST(TextHash, IsFnv1aByItsPublishedVectors) {
  EXPECT_EQ(fnv1a64(""), 0xcbf29ce484222325U);
  EXPECT_EQ(fnv1a64("a"), 0xaf63dc4c8601ec8cU);
  EXPECT_EQ(fnv1a64("foobar"), 0x85944171f73967e8U);
  EXPECT_EQ(text_hash("foobar"), "85944171f73967e8");
}

TEST(CellsOf, CountsInstancesSolversAndSeeds) {
  const std::vector<PlannedCell> cells = cells_of(study_of_two());
  ASSERT_EQ(cells.size(), 8U);
  EXPECT_EQ(cells[0].record.key.instance->seed, 4U);
  EXPECT_EQ(cells[0].record.key.instance->index, 10U);
  EXPECT_EQ(cells[7].record.key.instance->index, 11U);
  EXPECT_EQ(cells[7].record.key.label, "b");
  EXPECT_EQ(cells[7].record.key.seed, 6U);
  EXPECT_EQ(cells[7].record.number, 7);
}

TEST(CellIds, DependOnEverythingButTheLabel) {
  const CellKey key{.kind = CellKind::kRun,
                    .problem = "p",
                    .instance = Instance{1, 2},
                    .label = "label",
                    .solver = "s",
                    .seed = 3,
                    .budget = {.evaluations = 4, .seconds = 5.0},
                    .training = "t"};
  std::set<std::string> ids{cell_id(key)};
  const auto add = [&](auto change) {
    CellKey other = key;
    change(other);
    ids.insert(cell_id(other));
  };
  add([](CellKey& k) { k.kind = CellKind::kBound; });
  add([](CellKey& k) { k.problem = "q"; });
  add([](CellKey& k) { k.instance->seed = 9; });
  add([](CellKey& k) { k.instance->index = 9; });
  add([](CellKey& k) { k.instance.reset(); });
  add([](CellKey& k) { k.solver = "z"; });
  add([](CellKey& k) { k.seed = 9; });
  add([](CellKey& k) { k.budget.evaluations = 9; });
  add([](CellKey& k) { k.budget.seconds = 9.0; });
  add([](CellKey& k) { k.training = ""; });
  EXPECT_EQ(ids.size(), 11U);
  add([](CellKey& k) { k.label = "another"; });
  EXPECT_EQ(ids.size(), 11U);
}

TEST(CellIds, AreTheSameInEveryStudy) {
  Study larger = study_of_two();
  larger.problems[0].instances->first = 9;
  larger.problems[0].instances->count = 4;
  larger.seeds = {9, 6, 5};
  std::set<std::string> ids;
  for (const PlannedCell& cell : cells_of(larger)) ids.insert(cell.record.id);
  EXPECT_EQ(ids.size(), 24U);
  for (const PlannedCell& cell : cells_of(study_of_two())) EXPECT_TRUE(ids.contains(cell.record.id));
}

TEST(CellsOf, RefusesSolversThatAreTheSame) {
  Study study = study_of_two();
  study.solvers[1].text = "random";
  EXPECT_THAT(refusal(study), HasSubstr("solvers 'a' and 'b' are the same on seed/random_narrow: random"));
}

TEST(CellsOf, RefusesWhatIsMissingOrTwice) {
  const auto refused = [](auto change) {
    Study study = study_of_two();
    change(study);
    return refusal(study);
  };
  EXPECT_THAT(refused([](Study& s) { s.name.clear(); }), HasSubstr("it has no name"));
  EXPECT_THAT(refused([](Study& s) { s.problems.clear(); }), HasSubstr("no problem"));
  EXPECT_THAT(refused([](Study& s) { s.solvers.clear(); }), HasSubstr("no solver"));
  EXPECT_THAT(refused([](Study& s) { s.seeds.clear(); }), HasSubstr("no seed"));
  EXPECT_THAT(refused([](Study& s) { s.seeds = {1, 1}; }), HasSubstr("a seed occurs twice"));
  EXPECT_THAT(refused([](Study& s) { s.solvers[1].label = "a"; }), HasSubstr("solver 'a' occurs twice"));
  EXPECT_THAT(refused([](Study& s) { s.solvers[1].text.clear(); }), HasSubstr("'b' has no text"));
  EXPECT_THAT(refused([](Study& s) { s.solvers[1].solver = nullptr; }), HasSubstr("'b' is either given or trained"));
  EXPECT_THAT(refused([](Study& s) { s.problems[0].instances->count = 0; }), HasSubstr("0 instances (at least 1)"));
  EXPECT_THAT(
      refused([](Study& s) { s.problems[0].instances = InstanceRange{.first = 18446744073709551615U, .count = 2}; }),
      HasSubstr("2 instances from 18446744073709551615 on (no number may be above 18446744073709551615)"));
  EXPECT_THAT(refused([](Study& s) { s.mass_targets = {-1.0}; }), HasSubstr("a target of -1 % of the mass"));
}

TEST(StudyProblems, OfOneTargetHaveNoInstances) {
  EXPECT_FALSE(study_problem("seed/fixed").instances.has_value());
  EXPECT_EQ(study_problem("seed/random_wide").instances->count, 1);
  EXPECT_THROW(static_cast<void>(study_problem("seed/fixed", InstanceRange{})), std::invalid_argument);
}

TEST(StudyHashes, ChangeWithTheFileOfAProblem) {
  const test::TemporaryFolder folder;
  const std::filesystem::path source = test::source_folder() / "data/scenarios/seed_fixed.json";
  const std::filesystem::path file = folder.path() / "problem.json";
  std::filesystem::copy_file(source, file);
  const auto hash = [&] {
    Study study = study_of_two();
    study.problems = {study_problem(file.string())};
    return facts_of(study).hash;
  };
  const std::string before = hash();
  EXPECT_EQ(hash(), before);
  std::stringstream text;
  text << std::ifstream{file}.rdbuf();
  std::string changed = text.str();
  changed.replace(changed.find("\"maxModules\": 10"), 16, "\"maxModules\": 9");
  std::ofstream{file} << changed;
  EXPECT_NE(hash(), before);
}

}  // namespace
}  // namespace modsearch
