#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/study/targets.hpp>

#include "study/synthetic_study.hpp"

namespace modsearch {
namespace {

// A run on an instance whose best design has three modules and weighs 2 kg, certified; 188 = 198 - 5 * 2.
class TargetTest : public ::testing::Test {
 protected:
  TargetTest() {
    best_.outcome.emplace().score = 188.0;
    best_.outcome->modules = 3;
    best_.outcome->mass = 2.0;
    best_.outcome->terms = {{"mass", -10.0}};
    facts_.best = &best_;
    facts_.bound = 188.0;
    run_.trace = {{.evaluations = 3, .seconds = 0.1, .score = 305.0, .achieved = false, .modules = 2, .mass = 3.0},
                  {.evaluations = 10, .seconds = 0.2, .score = 60.0, .achieved = true, .modules = 4, .mass = 2.0},
                  {.evaluations = 20, .seconds = 0.3, .score = 184.0, .achieved = true, .modules = 3, .mass = 2.8},
                  {.evaluations = 50, .seconds = 0.4, .score = 187.5, .achieved = true, .modules = 3, .mass = 2.1}};
    run_.outcome.emplace().score = 187.5;
    run_.outcome->achieved = true;
    run_.outcome->spent.evaluations = 100;
    run_.outcome->spent.seconds = 0.5;
  }
  [[nodiscard]] TargetRun timed(const Target& target, Measure measure = Measure::kEvaluations) const {
    return target_run(run_, facts_, target, measure);
  }

  CellRecord best_;
  CellRecord run_;
  InstanceFacts facts_;
};

TEST_F(TargetTest, IsMetByTheFirstImprovementThatIsGoodEnough) {
  EXPECT_EQ(timed({Target::Kind::kAchieved}).runtime(), 10.0)
      << "the collision before it scores more and is worth less";
  EXPECT_EQ(timed({Target::Kind::kFewestModules}).runtime(), 20.0);
  EXPECT_EQ(timed({Target::Kind::kMass, 50.0}).runtime(), 20.0);
  EXPECT_EQ(timed({Target::Kind::kMass, 20.0}).runtime(), 50.0);
  EXPECT_EQ(timed({Target::Kind::kMass, 20.0}, Measure::kSeconds).runtime(), 0.4);
}

TEST_F(TargetTest, IsMissedAtTheCostOfTheWholeRun) {
  const TargetRun missed = timed({Target::Kind::kMass, 2.0});
  EXPECT_FALSE(missed.met);
  EXPECT_EQ(missed.spent, 100.0);
  EXPECT_EQ(missed.runtime(), INFINITY);
  EXPECT_EQ(timed({Target::Kind::kMass, 2.0}, Measure::kSeconds).spent, 0.5);
}

TEST_F(TargetTest, IsMissedByAFailedRunAtTheCostOfItsBudget) {
  CellRecord failed;
  failed.state = CellState::kFailed;
  failed.key.budget = {.evaluations = 700};
  EXPECT_EQ(target_run(failed, facts_, {Target::Kind::kAchieved}, Measure::kEvaluations).spent, 700.0);
  EXPECT_EQ(target_run(failed, facts_, {Target::Kind::kAchieved}, Measure::kSeconds).spent, 0.0);
  EXPECT_EQ(regret(failed, facts_), INFINITY);
}

TEST_F(TargetTest, MeasuresMassFromTheBound) {
  // The bound allows 1 point more than the best scores, so 0.2 kg less: 1.8 kg, of which 2.1 kg is within 20 %.
  facts_.bound = 189.0;
  EXPECT_NEAR(facts_.reference_mass(), 1.8, 1e-12);
  EXPECT_TRUE(timed({Target::Kind::kMass, 20.0}).met);
  EXPECT_FALSE(timed({Target::Kind::kMass, 10.0}).met);
}

TEST_F(TargetTest, OfRegretIsFiniteOnceTheTaskIsAchieved) {
  EXPECT_EQ(regret_after(run_, facts_, Measure::kEvaluations, 9), INFINITY);
  EXPECT_EQ(regret_after(run_, facts_, Measure::kEvaluations, 10), 128.0);
  EXPECT_EQ(regret_after(run_, facts_, Measure::kSeconds, 0.35), 4.0);
  EXPECT_EQ(regret(run_, facts_), 0.5);
  run_.outcome->achieved = false;
  EXPECT_EQ(regret(run_, facts_), INFINITY);
}

TEST(Targets, ComeFromTheEasiestOn) {
  StudyFacts study;
  study.mass_targets = {5, 0.1};
  const std::vector<Target> targets = targets_of(study);
  ASSERT_EQ(targets.size(), 4u);
  EXPECT_EQ(targets[0].name(), "achieved");
  EXPECT_EQ(targets[1].name(), "fewest modules");
  EXPECT_EQ(targets[2].name(), "mass within 5 %");
  EXPECT_EQ(targets[3].name(), "mass within 0.1 %");
}

TEST(PairedRuntimes, KeepWhatEverySolverHasRun) {
  const StudyRecord record = testing::synthetic_study({.instances = 3, .seeds = 4});
  const PairedRuntimes paired = paired_runtimes(runs_of(record), {Target::Kind::kAchieved}, Measure::kEvaluations);
  EXPECT_EQ(paired.dimensions.size(), 23u) << "6 instances with 4 seeds, less the run that has not ended";
  for (const std::vector<double>& row : paired.runtimes) EXPECT_EQ(row.size(), 23u);
}

}  // namespace
}  // namespace modsearch
