#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <modsearch/study/iohprofiler.hpp>
#include <modsearch/study/study_runs.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "study/synthetic_study.hpp"

namespace modsearch {
namespace {

using Rows = std::vector<std::vector<double>>;

// What their readers do: a header before every run, numbers behind it.
std::vector<Rows> runs_in(const std::string& data) {
  std::vector<Rows> runs;
  std::istringstream lines{data};
  std::string line;
  while (std::getline(lines, line)) {
    if (line.rfind("evaluations", 0) == 0) {
      EXPECT_EQ(line, "evaluations raw_y seconds achieved modules mass_kg");
      runs.emplace_back();
      continue;
    }
    std::istringstream numbers{line};
    runs.back().emplace_back();
    double number = 0.0;
    while (numbers >> number) runs.back().back().push_back(number);
    EXPECT_EQ(runs.back().back().size(), 6U) << line;
  }
  return runs;
}

std::map<std::string, std::string> files_of(const StudyRecord& record) {
  std::map<std::string, std::string> files;
  for (const NamedText& file : iohprofiler_files(record)) {
    EXPECT_TRUE(files.emplace(file.path, file.text).second) << file.path;
  }
  return files;
}

TEST(IohProfiler, HasAFolderPerSolverWithAFilePerProblemAndItsData) {
  const auto files = files_of(testing::synthetic_study({.instances = 4, .seeds = 3}));
  EXPECT_EQ(files.size(), 3U * 2U * 2U);
  ASSERT_TRUE(files.contains("1_steady/IOHprofiler_f2_seed_random_wide.json"));
  const auto json = nlohmann::json::parse(files.at("1_steady/IOHprofiler_f2_seed_random_wide.json"));
  EXPECT_EQ(json.at("function_id"), 2);
  EXPECT_EQ(json.at("function_name"), "seed/random_wide");
  EXPECT_EQ(json.at("maximization"), true);
  EXPECT_EQ(json.at("algorithm").at("name"), "steady");
  const auto& scenario = json.at("scenarios").at(0);
  EXPECT_EQ(scenario.at("dimension"), 3);  // a type and two lengths
  EXPECT_TRUE(files.contains("1_steady/" + scenario.at("path").get<std::string>()));
}

TEST(IohProfiler, EveryRunBeginsAtOneRisesAndEndsWithWhatItsListSays) {
  const auto files = files_of(testing::synthetic_study({.instances = 4, .seeds = 3}));
  int n_runs = 0;
  for (const auto& [path, text] : files) {
    if (path.substr(path.size() - 5) != ".json") continue;
    const auto json = nlohmann::json::parse(text);
    const auto& scenario = json.at("scenarios").at(0);
    const auto runs = runs_in(files.at(path.substr(0, path.find('/') + 1) + scenario.at("path").get<std::string>()));
    const auto& list = scenario.at("runs");
    ASSERT_EQ(runs.size(), list.size()) << path;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      ++n_runs;
      EXPECT_EQ(runs[r].front()[0], 1.0);
      EXPECT_EQ(runs[r].back()[0], list[r].at("evals").get<double>());
      EXPECT_EQ(runs[r].back()[1], list[r].at("best").at("y").get<double>());
      for (std::size_t i = 1; i < runs[r].size(); ++i) {
        EXPECT_GT(runs[r][i][0], runs[r][i - 1][0]);
        EXPECT_GE(runs[r][i][1], runs[r][i - 1][1]);
      }
    }
  }
  EXPECT_EQ(n_runs, 3 * 2 * 4 * 3 - 1);  // one has not ended
}

TEST(IohProfiler, ARunThatFailedHasOneLine) {
  const StudyRecord record = testing::synthetic_study({.instances = 4, .seeds = 3});
  int failed = 0;
  for (const auto& [path, text] : files_of(record)) {
    if (path.substr(path.size() - 4) != ".dat") continue;
    for (const Rows& run : runs_in(text)) {
      if (run.size() > 1) continue;
      ++failed;
      EXPECT_EQ(run.front()[1], std::numeric_limits<double>::lowest());
    }
  }
  EXPECT_EQ(failed, 1);
}

}  // namespace
}  // namespace modsearch
