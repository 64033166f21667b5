#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/solvers/checkpoint.hpp>
#include <string>

namespace modsearch::testing {

/// What every DesignProblem promises; run it on yours.
inline void expect_problem_contract(const DesignProblem& problem) {
  SCOPED_TRACE(problem.name());
  ASSERT_GE(problem.max_modules(), 1);
  EXPECT_TRUE(problem.context().allFinite());
  EXPECT_EQ(problem.context(), problem.context());
  EXPECT_NO_THROW((void)problem.evaluate({})) << "the empty design is allowed";
  ASSERT_FALSE(problem.stages().empty());
  EXPECT_EQ(problem.stages().back(), Fidelity::kFull);

  Rng rng{99};
  for (int i = 0; i < 50; ++i) {
    const Design design = random_design(problem, rng);
    ASSERT_LT(static_cast<int>(design.modules.size()), problem.max_modules());
    const Evaluation first = problem.evaluate(design);
    const Evaluation again = problem.evaluate(design);
    EXPECT_EQ(first.score, again.score) << "evaluate is a function of the design";
    EXPECT_EQ(first.attempt.achieved, again.attempt.achieved);
    const Evaluation screen = problem.evaluate(design, Fidelity::kScreen);
    EXPECT_FALSE(first.better_than(screen)) << "a screen is an upper bound";
    EXPECT_FALSE(screen.better_than(problem.evaluate(design, Fidelity::kPoses))) << "and poses alone are one of that";
    if (first.attempt.achieved) {
      EXPECT_LE(first.score, problem.optimism(design.types()).score + 1e-9) << "nothing beats the bound of its types";
      EXPECT_LE(first.score, problem.optimism_of_length(static_cast<int>(design.modules.size())).score + 1e-9);
    }
    for (std::size_t n = 0; first.attempt.achieved && n <= design.modules.size(); ++n) {
      EXPECT_LE(first.score, problem.optimism_of_prefix(design.prefix(static_cast<int>(n)).types(),
                                                        static_cast<int>(design.modules.size()))
                                     .score +
                                 1e-9)
          << "nor the bound of its first types";
    }
    for (std::size_t n = 0; n <= design.modules.size(); ++n) {
      EXPECT_NO_THROW((void)problem.evaluate(design.prefix(static_cast<int>(n)), Fidelity::kScreen))
          << "every prefix of a design is a design";
    }
  }
  const std::vector<int> full(static_cast<std::size_t>(problem.max_modules() - 1), 0);
  EXPECT_TRUE(problem.successors(full).empty()) << "nothing may follow when max_modules is reached";
}

/// What every Solver promises, on `problem`.
inline void expect_solver_contract(const Solver& solver, const DesignProblem& problem) {
  SCOPED_TRACE(solver.name() + " on " + problem.name());
  constexpr std::int64_t kBudget = 40;
  const auto solve = [&](std::int64_t evaluations, std::uint64_t seed) {
    Meter meter{{.evaluations = evaluations}};
    return solver.solve(problem, meter, Rng{seed});
  };
  const Solution solution = solve(kBudget, 1);
  EXPECT_LE(solution.spent.evaluations, kBudget) << "a budget of evaluations is exact";
  EXPECT_EQ(solution.design, solve(kBudget, 1).design) << "equal seeds give equal answers";
  const Witness witness{.postures = solution.evaluation.attempt.postures};
  EXPECT_EQ(problem.evaluate(solution.design, Fidelity::kFull, witness).score, solution.evaluation.score)
      << "the answer is what it says";
  EXPECT_EQ(solve(0, 1).spent.evaluations, 0);
  EXPECT_EQ(solve(1, 1).spent.evaluations, 1);

  Meter aimed{{.evaluations = 10'000, .target_score = -1e9}};
  const Solution first = solver.solve(problem, aimed, Rng{1});
  if (first.evaluation.attempt.achieved && first.stop == StopReason::kTargetScore) {
    EXPECT_GE(first.evaluation.score, -1e9);
  }

  std::stop_source source;
  source.request_stop();
  Meter stopped{{}, {}, source.get_token()};
  EXPECT_EQ(solver.solve(problem, stopped, Rng{1}).spent.evaluations, 0) << "nothing is evaluated after a stop";
}

/// What every SteppedSolver promises beside: a search that is cut off anywhere and resumed ends like one that was not.
/// Spends `budget` evaluations some ten times; the checkpoints go to `folder`.
inline void expect_resumable_contract(const SteppedSolver& solver, const DesignProblem& problem,
                                      const std::filesystem::path& folder, std::int64_t budget = 2000) {
  SCOPED_TRACE(solver.name() + " on " + problem.name());
  Meter whole{{.evaluations = budget}};
  const Solution uninterrupted = solver.solve(problem, whole, Rng{5});
  for (const std::int64_t cut : {budget / 100, budget / 10, budget / 3, budget - 1}) {
    SCOPED_TRACE("cut off after " + std::to_string(cut) + " evaluations");
    Checkpointing checkpointing{.file = folder / ("checkpoint-" + std::to_string(cut)), .period = 0.0};
    Meter first{{.evaluations = cut}};
    (void)solve(solver, problem, first, Rng{5}, checkpointing);
    checkpointing.resume = true;
    Meter second{{.evaluations = budget}};
    const Solution resumed = solve(solver, problem, second, Rng{5}, checkpointing);
    EXPECT_EQ(resumed.design, uninterrupted.design);
    EXPECT_EQ(resumed.evaluation.score, uninterrupted.evaluation.score);
    EXPECT_EQ(resumed.spent.evaluations, uninterrupted.spent.evaluations);
    EXPECT_EQ(resumed.spent.program_evaluations, uninterrupted.spent.program_evaluations);
    EXPECT_EQ(resumed.stop, uninterrupted.stop);
    ASSERT_EQ(second.trace().size(), whole.trace().size());
    for (std::size_t i = 0; i < whole.trace().size(); ++i) {
      EXPECT_EQ(second.trace()[i].evaluations, whole.trace()[i].evaluations);
      EXPECT_EQ(second.trace()[i].score, whole.trace()[i].score);
    }
  }
}

}  // namespace modsearch::testing
