#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/study/best_known.hpp>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using test::TemporaryFolder;
using test::text_of;
using ::testing::HasSubstr;

constexpr const char* kFamily = "seed/random_obstacles";

// A solution file of instance 0:`index`, as `solve` writes it, with `change` made to what it says.
std::filesystem::path solved(const TemporaryFolder& folder, const std::string& name, const Solver& solver,
                             std::uint64_t index, const std::function<void(SolutionRecord&)>& change = {}) {
  const Instance instance{0, index};
  const auto problem = load_problem(kFamily, instance);
  Meter meter{{.evaluations = 2000}};
  const Solution solution = solver.solve(*problem, meter, Rng{1});
  SolutionRecord record;
  record.problem = kFamily;
  record.instance = instance;
  record.design = solution.design;
  record.X_WB = problem->base_pose(solution.design);
  record.evaluation = solution.evaluation;
  record.solver = solver.name();
  record.solver_options = {{"starts", "4"}};
  record.seed = 1;
  record.evaluations = solution.spent.evaluations;
  record.seconds = 0.5;
  if (change) change(record);
  const std::filesystem::path file = folder.path() / name;
  write_solution(file, *problem, record);
  return file;
}

BestKnownMerge merged(const TemporaryFolder& folder, const std::vector<std::filesystem::path>& files) {
  return merge_best_known(folder.path() / "tables", files);
}

BestKnownTable table_of(const TemporaryFolder& folder) {
  return load_best_known(best_known_file(folder.path() / "tables", kFamily));
}

TEST(BestKnown, LiesInOneFilePerFamily) {
  EXPECT_EQ(best_known_file("tables", "whitman/3g_3o"), std::filesystem::path{"tables/whitman/3g_3o.json"});
}

TEST(BestKnown, TakesVerifiedDesignsIntoANewTableByInstance) {
  const TemporaryFolder folder;
  const BestKnownMerge merge =
      merged(folder, {solved(folder, "b.json", PerSequence{}, 3), solved(folder, "a.json", PerSequence{}, 1)});
  ASSERT_EQ(merge.counts.size(), 1U);
  EXPECT_EQ(merge.counts[0].family, kFamily);
  EXPECT_EQ(merge.counts[0].added, 2);
  EXPECT_TRUE(merge.refused.empty()) << merge.refused[0];
  EXPECT_EQ(merge.written, std::vector{best_known_file(folder.path() / "tables", kFamily)});
  const BestKnownTable table = table_of(folder);
  ASSERT_EQ(table.entries.size(), 2U);
  EXPECT_EQ(table.entries[0].instance.index, 1U);
  const BestKnown* third = table.find({0, 3});
  ASSERT_NE(third, nullptr);
  EXPECT_EQ(table.find({1, 3}), nullptr);
  const Evaluation again = load_problem(kFamily, {0, 3})->evaluate(third->design);
  EXPECT_TRUE(again.attempt.achieved);
  EXPECT_DOUBLE_EQ(again.score, third->score);
  EXPECT_EQ(third->postures.rows(), 1);
  EXPECT_EQ(third->solver, PerSequence{}.name());
  EXPECT_EQ(third->solver_options.at(0).second, "4");
  EXPECT_EQ(third->seconds, 0.5);
}

TEST(BestKnown, KeepsTheBetterOfTwoDesigns) {
  const TemporaryFolder folder;
  const auto worse = solved(folder, "worse.json", RandomSearch{}, 3);
  const auto better = solved(folder, "better.json", PerSequence{}, 3);
  ASSERT_EQ(merged(folder, {worse}).counts[0].added, 1);
  const double before = table_of(folder).entries[0].score;
  const BestKnownMerge improved = merged(folder, {better});
  EXPECT_EQ(improved.counts[0].improved, 1);
  EXPECT_GT(table_of(folder).entries[0].score, before + 1.0);
  const BestKnownMerge kept = merged(folder, {worse, better});
  EXPECT_EQ(kept.counts[0].kept, 2);
  EXPECT_TRUE(kept.written.empty());
}

TEST(BestKnown, RefusesADesignThatIsNotWhatItSays) {
  const TemporaryFolder folder;
  const auto astray = solved(folder, "astray.json", PerSequence{}, 3, [](SolutionRecord& record) {
    record.evaluation.attempt.postures.array() += 0.1;  // about 0.1 rad times the metres of the arm away from the goal
  });
  const auto empty = solved(folder, "empty.json", PerSequence{}, 1, [](SolutionRecord& record) {
    record.design = {};
    record.evaluation = load_problem(kFamily, {0, 1})->evaluate({});
  });
  const BestKnownMerge merge = merged(folder, {astray, empty});
  ASSERT_EQ(merge.refused.size(), 2U);
  EXPECT_THAT(merge.refused[0], HasSubstr("astray.json: the design for instance 0:3 of seed/random_obstacles does not "
                                          "verify: the posture given for goal '1' misses it by"));
  EXPECT_THAT(merge.refused[1], HasSubstr("empty.json: the design for instance 0:1 of seed/random_obstacles does not "
                                          "verify: not achieved: goal 1: "));
  EXPECT_TRUE(merge.written.empty());
  EXPECT_FALSE(std::filesystem::exists(best_known_file(folder.path() / "tables", kFamily)));
}

TEST(BestKnown, MergesOneTableIntoAnother) {
  const TemporaryFolder folder;
  (void)merged(folder, {solved(folder, "a.json", PerSequence{}, 1), solved(folder, "b.json", PerSequence{}, 3)});
  const std::vector tables{best_known_file(folder.path() / "tables", kFamily)};
  const BestKnownMerge merge = merge_best_known(folder.path() / "others", tables);
  EXPECT_EQ(merge.counts[0].added, 2);
  EXPECT_EQ(text_of(best_known_file(folder.path() / "others", kFamily)), text_of(tables[0]));
}

TEST(BestKnown, RefusesAFileOfAProblemThatIsNotBuiltIn) {
  const TemporaryFolder folder;
  const auto file = solved(folder, "a.json", PerSequence{}, 1);
  std::ofstream{folder.path() / "family.json"} << R"({"modsearch": 1, "family": "no/such", "designs": []})";
  const std::vector<std::filesystem::path> tables{folder.path() / "family.json"};
  EXPECT_THROW((void)merge_best_known(folder.path() / "tables", tables), FileError);
  std::string text = text_of(file);
  const std::string named = "\"problem\": \"seed/random_obstacles\"";
  text.replace(text.find(named), named.size(), "\"problem\": \"mine.json\"");
  std::ofstream{folder.path() / "mine_solved.json"} << text;
  const std::vector<std::filesystem::path> solutions{folder.path() / "mine_solved.json"};
  EXPECT_THROW((void)merge_best_known(folder.path() / "tables", solutions), FileError);
}

}  // namespace
}  // namespace modsearch
