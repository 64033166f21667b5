#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <modsearch/study/study_csv.hpp>
#include <sstream>

namespace modsearch {
namespace {

StudyRecord record_of_three() {
  StudyRecord record;
  CellRecord cell;
  cell.id = "a";
  cell.key = {.kind = CellKind::kRun,
              .problem = "p",
              .instance = Instance{1, 2},
              .label = "random, \"plain\"",
              .solver = "random",
              .seed = 3,
              .budget = {.evaluations = 10, .seconds = 1.0},
              .training = ""};
  cell.state = CellState::kDone;
  cell.trace = {{4, 0.5, 0.1, true, 2, 1.25}};
  cell.outcome.emplace();
  cell.outcome->score = 0.1;
  cell.outcome->goal_error = std::numeric_limits<double>::infinity();
  record.cells.push_back(cell);
  cell = {};
  cell.id = "b";
  cell.key.problem = "q";
  cell.key.label = "x";
  cell.state = CellState::kFailed;
  cell.failure = "two\nlines";
  record.cells.push_back(cell);
  cell.state = CellState::kStarted;
  record.cells.push_back(cell);
  return record;
}

TEST(RunsCsv, HasARowPerEndedCellWithAsManyFieldsAsTheHeader) {
  StudyRecord record = record_of_three();
  record.cells[0].key.label = "x";
  record.cells[1].failure = "x";
  std::istringstream lines{runs_csv(record)};
  std::string line;
  std::vector<std::ptrdiff_t> commas;
  while (std::getline(lines, line)) commas.push_back(std::count(line.begin(), line.end(), ','));
  ASSERT_EQ(commas.size(), 3U);  // the header and the two that have ended
  EXPECT_EQ(commas[1], commas[0]);
  EXPECT_EQ(commas[2], commas[0]);
}

TEST(RunsCsv, QuotesWhatNeedsIt) {
  const std::string text = runs_csv(record_of_three());
  EXPECT_NE(text.find("a,run,p,1,2,\"random, \"\"plain\"\"\",random,3,,1,done,0.1,0,0,1,0,Inf,"), std::string::npos) << text;
  EXPECT_NE(text.find("\"two\nlines\""), std::string::npos);
}

TEST(TracesCsv, HasARowPerImprovement) {
  EXPECT_EQ(traces_csv(record_of_three()),
            "cell,problem,instance_seed,instance,solver,seed,evaluations,seconds,score,achieved,modules,mass_kg\n"
            "a,p,1,2,\"random, \"\"plain\"\"\",3,4,0.5,0.1,1,2,1.25\n");
}

}  // namespace
}  // namespace modsearch
