#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/baselines/random_search.hpp>
#include <modsearch/baselines/refined.hpp>
#include <modsearch/problem/files.hpp>

namespace modsearch {
namespace {

// Evaluates one design, whatever it is worth, and says about it what it is told to.
class OneDesign final : public Solver {
 public:
  explicit OneDesign(Design design, StopReason stop = StopReason::kExhausted)
      : design_{std::move(design)}, stop_{stop} {}
  [[nodiscard]] std::string name() const override { return "one"; }

 private:
  [[nodiscard]] SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng) const override {
    static_cast<void>(meter.evaluate(problem, design_));
    return {.stop = stop_, .reason = "one design"};
  }
  Design design_;
  StopReason stop_;
};

// Of one hinge with both lengths at 1.5 m, which misses the goal of seed/fixed.
Design long_hinge(const DesignProblem& problem) {
  int hinge = 0;
  while (problem.library().type(hinge).id != "hinge") ++hinge;
  return {{{hinge, Eigen::Vector2d{1.5, 1.5}}}};
}

TEST(Refined, KeepsTheTypesAndSolvesForTheLengths) {
  const auto problem = load_problem("seed/fixed");
  const Design design = long_hinge(*problem);
  Meter meter;
  const Solution solution = Refined{std::make_shared<OneDesign>(design)}.solve(*problem, meter, Rng{0});
  EXPECT_EQ(solution.design.types(), design.types());
  EXPECT_NEAR(solution.evaluation.score, 341.9148, 1e-3);
  EXPECT_EQ(solution.reason, "one design; its sequence solved from 8 starts");
}

TEST(Refined, AddsNothingToAProof) {
  const auto problem = load_problem("seed/fixed");
  const auto first = std::make_shared<OneDesign>(long_hinge(*problem), StopReason::kOptimal);
  Meter meter;
  const Solution solution = Refined{first}.solve(*problem, meter, Rng{0});
  EXPECT_EQ(solution.stop, StopReason::kOptimal);
  EXPECT_EQ(solution.spent.evaluations, 1);
  EXPECT_EQ(solution.reason, "one design");
}

TEST(Refined, EndsWithTheBudgetOfTheFirst) {
  const auto problem = load_problem("seed/fixed");
  Meter meter{{.evaluations = 1}};
  const Solution solution = Refined{std::make_shared<OneDesign>(long_hinge(*problem))}.solve(*problem, meter, Rng{0});
  EXPECT_EQ(solution.spent.evaluations, 1);
  EXPECT_EQ(solution.stop, StopReason::kEvaluations);
  EXPECT_EQ(solution.reason, "one design; nothing of the budget is left to solve its sequence");
}

TEST(Refined, RefusesWhatCannotBe) {
  EXPECT_THROW(Refined{nullptr}, std::invalid_argument);
  EXPECT_THROW((Refined{std::make_shared<RandomSearch>(), {.starts = 0}}), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
