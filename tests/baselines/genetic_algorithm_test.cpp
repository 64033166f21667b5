#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/baselines/genetic_algorithm.hpp>
#include <modsearch/problem/files.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

using ::testing::HasSubstr;

// PROBLEM 5: the optimum of seed/fixed is one hinge, 350 - 5 (0.5 + sqrt(1.25) - 0.001) = 341.9148; designs of one
// module that reach are one in 1500, and two modules score 188 at most.
const double kOptimum = 350.0 - 5.0 * (0.5 + std::sqrt(1.25) - 0.001);

TEST(GeneticAlgorithm, FindsTheThinOptimumOfSeedFixedByEvolutionAlone) {
  const auto problem = load_problem("seed/fixed");
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Meter meter{{.evaluations = 5000}};
    const Solution solution = GeneticAlgorithm{{.polish = 0}}.solve(*problem, meter, Rng{seed});
    EXPECT_EQ(solution.design.modules.size(), 1u) << "seed " << seed;
    EXPECT_GT(solution.evaluation.score, kOptimum - 2.0) << "seed " << seed;
    EXPECT_LE(solution.evaluation.score, kOptimum + 1e-9);
  }
}

TEST(GeneticAlgorithm, FindsItExactlyWithPolish) {
  const auto problem = load_problem("seed/fixed");
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Meter meter{{.evaluations = 500}};
    const Solution solution = GeneticAlgorithm{}.solve(*problem, meter, Rng{seed});
    EXPECT_NEAR(solution.evaluation.score, kOptimum, 1e-3) << "seed " << seed;
  }
}

// Two types without parameters in at most three places: 2 + 4 + 8 designs and the empty one. The score counts links
// from the base on, and a design that was evaluated once is never evaluated again.
class Beads final : public DesignProblem {
 public:
  Beads() {
    const auto seed = load_library("seed");
    std::vector<ModuleType> modules{seed->base()};
    for (const char* id : {"link", "rotary"}) {
      ModuleType type = seed->type(seed->find(id).value());
      for (ParameterRange& range : type.parameters) range.lower = range.upper = 1.0;
      modules.push_back(type);
    }
    library_ = std::make_shared<ModuleLibrary>("beads", std::move(modules));
  }
  [[nodiscard]] std::string name() const override { return "beads"; }
  [[nodiscard]] const ModuleLibrary& library() const override { return *library_; }
  [[nodiscard]] int max_modules() const override { return 4; }
  [[nodiscard]] Eigen::VectorXd context() const override { return Eigen::VectorXd::Zero(1); }

 private:
  [[nodiscard]] Evaluation do_evaluate(const Design& design, Fidelity) const override {
    Evaluation evaluation;
    evaluation.attempt.achieved = !design.modules.empty();
    for (const Placement& placement : design.modules) evaluation.score = placement.type == 0 ? 1.0 : 0.0;
    if (design.types() == std::vector<int>{0, 1, 0}) evaluation.score = 2.0;
    if (design.modules.empty()) evaluation.score = 0.0;
    return evaluation;
  }
  std::shared_ptr<const ModuleLibrary> library_;
};

TEST(GeneticAlgorithm, EvaluatesNoDesignTwiceAndEndsWhenNoneIsLeft) {
  Meter meter;
  const Solution solution = GeneticAlgorithm{}.solve(Beads{}, meter, Rng{1});
  EXPECT_EQ(solution.stop, StopReason::kExhausted);
  EXPECT_EQ(solution.spent.evaluations, 15);
  EXPECT_EQ(solution.design.types(), (std::vector<int>{0, 1, 0}));
  EXPECT_THAT(solution.reason, HasSubstr("without a new design"));
}

TEST(GeneticAlgorithm, RefusesOptionsOutOfRange) {
  EXPECT_THROW(GeneticAlgorithm{{.population = 1}}, std::invalid_argument);
  EXPECT_THROW(GeneticAlgorithm{{.tournament = 0}}, std::invalid_argument);
  EXPECT_THROW(GeneticAlgorithm{{.crossover = 1.5}}, std::invalid_argument);
  EXPECT_THROW(GeneticAlgorithm{{.structure = -0.1}}, std::invalid_argument);
  EXPECT_THROW(GeneticAlgorithm{{.step = 0.0}}, std::invalid_argument);
  EXPECT_THROW(GeneticAlgorithm{{.precision = -1}}, std::invalid_argument);
  EXPECT_THROW(GeneticAlgorithm{{.polish = -1}}, std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
