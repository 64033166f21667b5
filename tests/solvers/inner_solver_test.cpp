// The contract of `minimise`: every inner solver is run on every program.
#include <gtest/gtest.h>

#include <modsearch/solvers/inner_solver.hpp>
#include <set>

#include "solvers/test_programs.hpp"

namespace modsearch::test {
namespace {

class EveryInner : public testing::TestWithParam<Inner> {
 protected:
  [[nodiscard]] static InnerResult solve(SmoothProgram& program, const Eigen::VectorXd& start,
                                         const InnerOptions& options = {}) {
    Meter meter;
    return minimise(GetParam(), program, start, options, meter);
  }

  static void expect_within_bounds(const SmoothProgram& program, const Eigen::VectorXd& v) {
    ASSERT_EQ(v.size(), program.n_variables());
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      EXPECT_GE(v[i], program.lower()[i]);
      EXPECT_LE(v[i], program.upper()[i]);
    }
  }

  // What is claimed of the point is what the program says of it.
  static void expect_honest(SmoothProgram& program, const InnerResult& result) {
    expect_within_bounds(program, result.v);
    SmoothProgram::Values values;
    program.evaluate(result.v, values);
    EXPECT_EQ(result.objective, values.objective);
    EXPECT_EQ(result.violation, program.violation(result.v, values.rows));
    if (result.status == InnerStatus::kConverged) {
      EXPECT_LE(result.violation, InnerOptions{}.tolerance);
    }
  }

  [[nodiscard]] static Eigen::VectorXd near_hinge() { return Eigen::Vector4d{1.0, 1.0, 0.3, 1.0}; }
};

INSTANTIATE_TEST_SUITE_P(Packages, EveryInner, testing::ValuesIn(inner_solvers()),
                         [](const auto& test) { return std::string{name(test.param)}; });

// Optimality within 1e-9 of scaled residuals leaves the objective uncertain by the multipliers (about 1) times as much,
// and the methods that end by a step size by somewhat more.
TEST_P(EveryInner, FindsTheOptimumOfHockSchittkowski71) {
  HockSchittkowski71 program;
  const InnerResult result = solve(program, HockSchittkowski71::usual_start());
  expect_honest(program, result);
  EXPECT_EQ(result.status, InnerStatus::kConverged);
  EXPECT_NEAR(result.objective, HockSchittkowski71::kOptimum, 1e-6);
}

TEST_P(EveryInner, FindsTheBottomOfRosenbrocksValley) {
  RosenbrockInBall program{1.45};
  const InnerResult result = solve(program, Eigen::Vector2d{-1.0, 1.0});
  expect_honest(program, result);
  EXPECT_NEAR(result.objective, 0.0, 1e-7);
}

TEST_P(EveryInner, FindsTheLowestPointOfTheValleyInABall) {
  RosenbrockInBall program{1.0};
  const InnerResult result = solve(program, Eigen::Vector2d{-0.5, 0.5});
  expect_honest(program, result);
  EXPECT_NEAR(result.objective, 0.045674808, 1e-6);
  EXPECT_NEAR(result.v[0], 0.786415, 1e-4);
  EXPECT_NEAR(result.v[1], 0.617698, 1e-4);
}

TEST_P(EveryInner, FindsTheShortestHinge) {
  ArmProgram program = OneHinge::program();
  const InnerResult result = solve(program, near_hinge());
  expect_honest(program, result);
  EXPECT_EQ(result.status, InnerStatus::kConverged);
  EXPECT_NEAR(result.objective, OneHinge::optimum(), 1e-7);
  EXPECT_NEAR(result.v[0], 0.5, 1e-7);
}

TEST_P(EveryInner, ReachesMostRandomTargetsOfArmsFromAFewStarts) {
  for (const int joints : {3, 4, 5, 6}) {
    int reached = 0;
    for (unsigned seed = 0; seed < 4; ++seed) {
      ArmProgram program = random_arm(joints, seed);
      bool any = false;
      for (int k = 0; k < 4 && !any; ++k) {
        const InnerResult result = solve(program, program.start(k));
        expect_honest(program, result);
        any = result.violation <= InnerOptions{}.tolerance;
      }
      reached += any ? 1 : 0;
    }
    EXPECT_GE(reached, 3) << joints << " joints";
  }
}

TEST_P(EveryInner, SaysThatNothingIsFeasible) {
  Infeasible program;
  const InnerResult result = solve(program, Eigen::Vector2d{0.3, 0.6});
  expect_honest(program, result);
  EXPECT_NE(result.status, InnerStatus::kConverged);
  EXPECT_NEAR(result.violation, 1.0, 1e-6);  // x + y = 2 where 3 is asked for
}

TEST_P(EveryInner, FindsTheOptimumOfAProgramThatLeavesOutRows) {
  LeavesOutRows program;
  for (int again = 0; again < 2; ++again) {  // rows from the first time do not count the second time
    const InnerResult result = solve(program, Eigen::Vector2d{0.1, 0.2});
    expect_honest(program, result);
    EXPECT_EQ(program.n_rows(), 2);
    EXPECT_NEAR(result.objective, LeavesOutRows::kOptimum, 1e-6);
    EXPECT_NEAR(result.v[0], 2.0 / 3.0, 1e-4);
  }
}

TEST_P(EveryInner, JudgesByAllRowsWhereItIsStopped) {
  for (int call = 1; call < 8; ++call) {
    std::stop_source source;
    LeavesOutRows program{[&](int now) {
      if (now == call) source.request_stop();
    }};
    Meter meter{{}, {}, source.get_token()};
    const InnerResult result = minimise(GetParam(), program, Eigen::Vector2d{0.1, 0.2}, {}, meter);
    const double violation =
        std::max({0.0, result.v[0] + 2.0 * result.v[1] - 2.0, 2.0 * result.v[0] + result.v[1] - 2.0});
    EXPECT_NEAR(result.violation, violation, 1e-12);
  }
}

TEST_P(EveryInner, KeepsFixedVariablesWhereTheyAre) {
  ArmProgram free = OneHinge::program();
  Wrapped program{free, {}};
  program.set_bounds(0, 0.75, 0.75);
  const InnerResult result = solve(program, near_hinge());
  expect_honest(program, result);
  EXPECT_EQ(result.v[0], 0.75);
  EXPECT_NEAR(result.objective, 0.75 + std::hypot(1.0, 0.25) - 0.001, 1e-7);
}

TEST_P(EveryInner, EvaluatesTheOnlyPointIfAllVariablesAreFixed) {
  ArmProgram free = OneHinge::program();
  Wrapped program{free, {}};
  for (Eigen::Index i = 0; i < 4; ++i) program.set_bounds(i, near_hinge()[i], near_hinge()[i]);
  const InnerResult result = solve(program, near_hinge());
  expect_honest(program, result);
  EXPECT_EQ(result.status, InnerStatus::kInfeasible);
  EXPECT_EQ(result.evaluations, 1);
}

TEST_P(EveryInner, TakesEndlessJoints) {
  ArmProgram bounded = OneHinge::program();
  Wrapped program{bounded, {}};
  program.set_bounds(2, -kInf, kInf);
  program.set_bounds(3, -kInf, kInf);
  const InnerResult result = solve(program, near_hinge());
  expect_honest(program, result);
  EXPECT_NEAR(result.objective, OneHinge::optimum(), 1e-7);
}

TEST_P(EveryInner, StartsWithinTheBoundsEvenIfToldOtherwise) {
  ArmProgram inner = OneHinge::program();
  Wrapped program{inner, {}, [&](const Eigen::VectorXd& v, SmoothProgram::Values&) { expect_within_bounds(inner, v); }};
  const InnerResult result = solve(program, Eigen::Vector4d{9.0, -9.0, 9.0, -9.0});
  expect_within_bounds(inner, result.v);
}

TEST_P(EveryInner, GivesEqualResultsTwice) {
  ArmProgram program = random_arm(3, 11);
  const InnerResult first = solve(program, program.start(1), {.seed = 5});
  const InnerResult second = solve(program, program.start(1), {.seed = 5});
  EXPECT_EQ(first.v, second.v);
  EXPECT_EQ(first.objective, second.objective);
  EXPECT_EQ(first.evaluations, second.evaluations);
}

TEST_P(EveryInner, LetsAnExceptionOfTheProgramThroughAndWorksAgainAfterwards) {
  ArmProgram inner = OneHinge::program();
  for (const int call : {1, 2, 5}) {
    Wrapped program = throwing_at_call(inner, call);
    Meter meter;
    try {
      (void)minimise(GetParam(), program, near_hinge(), {}, meter);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const Sabotage& sabotage) {
      EXPECT_EQ(std::string{sabotage.what()}, "call " + std::to_string(call));
    }
    EXPECT_EQ(program.calls(), call) << "the program was called again after it had thrown";
    EXPECT_EQ(meter.progress().program_evaluations, call);
  }
  EXPECT_EQ(solve(inner, near_hinge()).status, InnerStatus::kConverged);
}

// Half the space is not a number; the optimum is in the other half, where the search starts.
TEST_P(EveryInner, TakesNotANumberForAFailedStep) {
  ArmProgram inner = OneHinge::program();
  Wrapped program = nan_beyond(inner, 0, 1.05);
  const InnerResult result = solve(program, near_hinge());
  expect_honest(inner, result);
  EXPECT_NEAR(result.objective, OneHinge::optimum(), 1e-6);
}

TEST_P(EveryInner, NeverAnswersWithNotANumber) {
  ArmProgram inner = OneHinge::program();
  for (const double limit : {0.5001, 0.6, 0.99}) {  // the start itself, at 1.0, is not a number
    Wrapped program = nan_beyond(inner, 0, limit);
    const InnerResult result = solve(program, near_hinge());
    expect_within_bounds(inner, result.v);
    EXPECT_FALSE(std::isnan(result.objective));
    EXPECT_FALSE(std::isnan(result.violation));
    if (result.status == InnerStatus::kConverged) expect_honest(program, result);
  }
}

TEST_P(EveryInner, FailsWhereNothingIsANumber) {
  ArmProgram inner = OneHinge::program();
  Wrapped program = nan_beyond(inner, 0, -kInf);
  const InnerResult result = solve(program, near_hinge());
  EXPECT_EQ(result.status, InnerStatus::kFailed);
  EXPECT_EQ(result.violation, kInf);
  expect_within_bounds(inner, result.v);
}

TEST_P(EveryInner, StopsWhenTheMeterSaysSo) {
  ArmProgram inner = random_arm(4, 3);
  std::stop_source source;
  Wrapped program = stopping_at_call(inner, 7, source);
  Meter meter{{}, {}, source.get_token()};
  const InnerResult result = minimise(GetParam(), program, inner.start(0), {}, meter);
  EXPECT_EQ(result.status, InnerStatus::kStopped);
  EXPECT_LE(program.calls(),
            8);  // at most one more: the stop falls within an evaluation, the answer is asked for after
  expect_honest(inner, result);
}

TEST_P(EveryInner, DoesNotBeginIfTheMeterSaysStop) {
  ArmProgram inner = OneHinge::program();
  Wrapped program{inner, {}};
  Meter meter{{.evaluations = 0}};
  const InnerResult result = minimise(GetParam(), program, near_hinge(), {}, meter);
  EXPECT_EQ(result.status, InnerStatus::kStopped);
  EXPECT_EQ(program.calls(), 0);
  expect_within_bounds(inner, result.v);
}

TEST_P(EveryInner, CountsItsEvaluationsInTheMeter) {
  ArmProgram inner = OneHinge::program();
  Wrapped program{inner, {}};
  Meter meter;
  const InnerResult result = minimise(GetParam(), program, near_hinge(), {}, meter);
  EXPECT_EQ(result.evaluations, program.calls());
  EXPECT_EQ(meter.progress().program_evaluations, program.calls());
  EXPECT_EQ(meter.progress().evaluations, 0);  // those are of the score
}

TEST_P(EveryInner, WritesNothing) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  ArmProgram program = random_arm(3, 1);
  (void)solve(program, program.start(0));
  Infeasible infeasible;
  (void)solve(infeasible, infeasible.start(0));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_P(EveryInner, RefusesAStartOfAnotherSizeOrThatIsNotFinite) {
  ArmProgram program = OneHinge::program();
  EXPECT_THROW((void)solve(program, Eigen::Vector3d::Zero()), std::invalid_argument);
  EXPECT_THROW((void)solve(program, Eigen::Vector4d{1.0, kInf, 0.0, 0.0}), std::invalid_argument);
}

TEST(Minimise, RefusesOptionsThatMakeNoSense) {
  ArmProgram program = OneHinge::program();
  Meter meter;
  const Eigen::VectorXd start = program.start(0);
  EXPECT_THROW((void)minimise(Inner::kOwn, program, start, {.max_iterations = 0}, meter), std::invalid_argument);
  EXPECT_THROW((void)minimise(Inner::kOwn, program, start, {.max_evaluations = 0}, meter), std::invalid_argument);
  EXPECT_THROW((void)minimise(Inner::kOwn, program, start, {.tolerance = 0.0}, meter), std::invalid_argument);
  EXPECT_THROW((void)minimise(Inner::kOwn, program, start, {.tolerance = std::nan("")}, meter), std::invalid_argument);
  EXPECT_THROW((void)minimise(Inner::kOwn, program, start, {.first_penalty = 0.0}, meter), std::invalid_argument);
}

TEST(InnerNames, AreUniqueAndReadBack) {
  std::set<std::string_view> names;
  for (const Inner inner : inner_solvers()) {
    EXPECT_EQ(inner_from_name(name(inner)), inner);
    names.insert(name(inner));
  }
  EXPECT_EQ(names.size(), 9U);
  EXPECT_EQ(inner_from_name("newton"), std::nullopt);
}

}  // namespace
}  // namespace modsearch::test
