#pragma once

#include <gtest/gtest.h>

#include <modsearch/rl/learner.hpp>

namespace modsearch::testing {

/// What every Learner promises, on a family of problems; run it on yours. It trains a few times, so choose a short
/// training. `instance` is one of the family.
inline void expect_learner_contract(const Learner& learner, const ProblemSource& source, const DesignProblem& instance) {
  SCOPED_TRACE(learner.name());
  const auto train = [&](std::uint64_t seed) {
    Meter meter{{.evaluations = 1'000'000}};
    return learner.train(source, meter, Rng{seed});
  };
  const auto use = [&](const Solver& policy, std::uint64_t seed) {
    Meter meter{{.evaluations = 1000}};
    return policy.solve(instance, meter, Rng{seed});
  };
  const Training first = train(1);
  ASSERT_NE(first.policy, nullptr) << "a training gives a solver";
  EXPECT_GT(first.spent.evaluations, 0) << "training is metered";
  ASSERT_FALSE(first.history.empty());
  for (std::size_t i = 1; i < first.history.size(); ++i) {
    EXPECT_GT(first.history[i].episode, first.history[i - 1].episode);
    EXPECT_GE(first.history[i].steps, first.history[i - 1].steps);
  }

  const Solution solution = use(*first.policy, 1);
  EXPECT_GT(solution.spent.evaluations, 0) << "use is metered apart";
  EXPECT_LT(solution.spent.evaluations, first.spent.evaluations);
  EXPECT_EQ(instance.evaluate(solution.design).score, solution.evaluation.score) << "the answer is what it says";
  EXPECT_EQ(use(*first.policy, 1).design, solution.design) << "a policy is a function of its arguments";

  const Training again = train(1);
  ASSERT_EQ(again.history.size(), first.history.size());
  for (std::size_t i = 0; i < first.history.size(); ++i) {
    EXPECT_EQ(again.history[i].evaluation.mean_return, first.history[i].evaluation.mean_return)
        << "equal seeds give equal trainings";
  }
  EXPECT_EQ(use(*again.policy, 1).design, solution.design) << "and equal policies";

  Meter stopped{{.evaluations = 25}};
  const Training cut = learner.train(source, stopped, Rng{1});
  EXPECT_LE(stopped.progress().evaluations, 25) << "a budget of evaluations is exact";
  EXPECT_EQ(cut.end, TrainingEnd::kInterrupted);
  EXPECT_NE(cut.policy, nullptr) << "a training that was cut off still gives what it has";

  Meter none{{.evaluations = 0}};
  EXPECT_EQ(first.policy->solve(instance, none, Rng{1}).spent.evaluations, 0);
}

}  // namespace modsearch::testing
