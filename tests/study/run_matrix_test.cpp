#include <gtest/gtest.h>

#include <modsearch/study/run_matrix.hpp>
#include <modsearch/study/study_runs.hpp>
#include <modsearch/study/targets.hpp>
#include <sstream>

#include "study/synthetic_study.hpp"

namespace modsearch {
namespace {

std::vector<std::vector<std::string>> rows_of(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines{csv};
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream fields{line};
    rows.emplace_back();
    std::string field;
    while (std::getline(fields, field, ',')) rows.back().push_back(field);
  }
  return rows;
}

TEST(RunMatrix, HasARowPerSolverAndSeedAndAColumnPerInstance) {
  const StudyRecord record = testing::synthetic_study({.instances = 4, .seeds = 3});
  const auto rows = rows_of(score_matrix_csv(record));
  ASSERT_EQ(rows.size(), 1U + 3U * 3U);
  for (const auto& row : rows) EXPECT_EQ(row.size(), 2U + 2U * 4U);
  EXPECT_EQ(rows[0][2], "seed/random_narrow 1:0");
}

TEST(RunMatrix, HasTheScoresAndRegretsOfTheRuns) {
  const StudyRecord record = testing::synthetic_study({.instances = 4, .seeds = 3});
  const StudyRuns runs = runs_of(record);
  const auto scores = rows_of(score_matrix_csv(record));
  const auto regrets = rows_of(regret_matrix_csv(record));
  std::size_t row = 0;
  int failed = 0;
  int missing = 0;
  for (std::size_t s = 0; s < runs.solvers.size(); ++s) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      ++row;
      ASSERT_EQ(scores[row][0], runs.solvers[s].label);
      ASSERT_EQ(scores[row][1], regrets[row][1]);
      for (std::size_t i = 0; i < runs.instances.size(); ++i) {
        const CellRecord* run = nullptr;
        for (const CellRecord* cell : runs.runs[s][i]) {
          if (std::to_string(cell->key.seed) == scores[row][1]) run = cell;
        }
        const std::string& score = scores[row][2 + i];
        const std::string& lost = regrets[row][2 + i];
        if (run == nullptr) {
          EXPECT_EQ(score, "NaN");
          EXPECT_EQ(lost, "NaN");
          ++missing;
        } else if (!run->outcome || !run->outcome->achieved) {
          EXPECT_EQ(score, "-Inf");
          EXPECT_EQ(lost, "Inf");
          ++failed;
        } else {
          EXPECT_EQ(std::stod(score), run->outcome->score);
          EXPECT_EQ(std::stod(lost), regret(*run, runs.instances[i]));
        }
      }
    }
  }
  EXPECT_GT(failed, 0);  // the study has all three kinds
  EXPECT_GT(missing, 0);
}

}  // namespace
}  // namespace modsearch
