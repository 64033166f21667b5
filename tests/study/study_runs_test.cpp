#include <gtest/gtest.h>

#include <modsearch/study/study_runs.hpp>

#include "study/synthetic_study.hpp"

namespace modsearch {
namespace {

using testing::synthetic_study;

TEST(StudyRuns, HoldsEveryRunThatHasEnded) {
  const StudyRecord record = synthetic_study({.instances = 3, .seeds = 4});
  const StudyRuns runs = runs_of(record);
  ASSERT_EQ(runs.solvers.size(), 3u);
  EXPECT_EQ(runs.instances.size(), 6u);
  EXPECT_EQ(runs.n_runs(0), 24);
  EXPECT_EQ(runs.n_runs(1), 23) << "one has not ended";
  EXPECT_EQ(runs.n_failed(1), 1);
  EXPECT_EQ(runs.n_failed(0), 0);
}

TEST(StudyRuns, CanBeThoseOfOneProblem) {
  const StudyRecord record = synthetic_study({.instances = 3, .seeds = 4});
  const StudyRuns runs = runs_of(record, "seed/random_wide");
  EXPECT_EQ(runs.instances.size(), 3u);
  EXPECT_EQ(runs.n_runs(0), 12);
  for (const InstanceFacts& facts : runs.instances) EXPECT_EQ(facts.problem, "seed/random_wide");
}

TEST(InstanceFacts, MeasuresFromTheBoundWhereThereIsOne) {
  const StudyRecord record = synthetic_study({.instances = 2, .seeds = 4});
  const StudyRuns runs = runs_of(record);
  const InstanceFacts& bounded = runs.instances[1];
  EXPECT_EQ(bounded.name(), "seed/random_narrow 1:1");
  EXPECT_EQ(bounded.certainty(), Certainty::kBounded);
  EXPECT_NEAR(*bounded.reference_score(), 350.0 - 5.0 * 1.62, 1e-9);
  EXPECT_NEAR(bounded.reference_mass(), 1.62, 1e-9) << "the mass at which two modules score the bound";
  EXPECT_EQ(bounded.reference_modules(), 2);
  EXPECT_EQ(bounded.dimension(), 3) << "a type and two lengths";

  const InstanceFacts& open = runs.instances[3];
  EXPECT_EQ(open.certainty(), Certainty::kNone);
  EXPECT_EQ(*open.reference_score(), open.best->outcome->score);
  EXPECT_EQ(open.reference_mass(), open.best->outcome->mass);
}

TEST(InstanceFacts, IsOptimalWhereTheBestScoresTheBound) {
  StudyRecord record = synthetic_study({.instances = 1, .seeds = 1});
  CellRecord& bound = record.cells[1];
  ASSERT_EQ(bound.key.kind, CellKind::kBound);
  bound.outcome->bound->score = record.cells[2].outcome->score;
  EXPECT_EQ(runs_of(record).instances[0].certainty(), Certainty::kOptimal);
}

TEST(InstanceFacts, NeverTakesABoundBelowWhatIsAchieved) {
  StudyRecord record = synthetic_study({.instances = 1, .seeds = 1});
  record.cells[1].outcome->bound->score = 300.0;
  const StudyRuns runs = runs_of(record);
  EXPECT_EQ(*runs.instances[0].reference_score(), runs.instances[0].best->outcome->score);
}

TEST(StudyRuns, LeaveOutInstancesThatAreProvedUnreachable) {
  StudyRecord record = synthetic_study({.instances = 1, .seeds = 2});
  record.cells[1].outcome->stop = "unreachable";
  record.cells[1].outcome->bound.reset();
  for (CellRecord& cell : record.cells) {
    if (cell.outcome) cell.outcome->achieved = false;
  }
  const StudyRuns runs = runs_of(record, "seed/random_narrow");
  EXPECT_EQ(runs.instances[0].certainty(), Certainty::kUnreachable);
  EXPECT_EQ(runs.n_runs(0), 0);
}

TEST(TrainingCost, IsThatOfTheTrainingsBehindTheRuns) {
  const StudyRecord record = synthetic_study({.instances = 2, .seeds = 2});
  const StudyRuns runs = runs_of(record);
  EXPECT_FALSE(training_cost(record, runs, 0));
  const std::optional<TrainingCost> cost = training_cost(record, runs, 2);
  ASSERT_TRUE(cost);
  EXPECT_EQ(cost->evaluations, 20'000.0);
  EXPECT_EQ(cost->seconds, 40.0);
  EXPECT_EQ(cost->trainings, 1);
}

TEST(TrainingCost, IsAveragedOverSeedsAndSummedOverFamilies) {
  StudyRecord record = synthetic_study({.instances = 2, .seeds = 2});
  // Two more trainings: one on the same family, and one on another that the first run of the agent uses.
  const auto training = std::find_if(record.cells.begin(), record.cells.end(),
                                     [](const CellRecord& cell) { return cell.key.kind == CellKind::kTraining; });
  CellRecord again = *training, other = *training;
  again.id = "again";
  again.outcome->cpu_seconds = 60.0;
  other.id = "other";
  other.key.problem = "another family";
  other.outcome->cpu_seconds = 7.0;
  other.outcome->spent.evaluations = 100;
  int seen = 0;
  for (CellRecord& cell : record.cells) {
    if (cell.key.training.empty()) continue;
    if (seen == 0) cell.key.training = "again";
    if (seen == 1) cell.key.training = "other";
    ++seen;
  }
  ASSERT_GT(seen, 2);
  record.cells.push_back(again);
  record.cells.push_back(other);
  const std::optional<TrainingCost> cost = training_cost(record, runs_of(record), 2);
  ASSERT_TRUE(cost);
  EXPECT_EQ(cost->seconds, 50.0 + 7.0);
  EXPECT_EQ(cost->evaluations, 20'000.0 + 100.0);
  EXPECT_EQ(cost->trainings, 3);
}

}  // namespace
}  // namespace modsearch
