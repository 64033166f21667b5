#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/smooth_program.hpp>
#include <set>

#include "solvers/test_programs.hpp"

namespace modsearch::test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// Two balls, one of radius 0, a single row in a ball, a row in an interval and one that is free: c_i = v_i^2 + v_0.
class Mixture final : public TestProgram {
 public:
  Mixture() {
    lower_ = Eigen::VectorXd::Constant(6, -2.0);
    upper_ = Eigen::VectorXd::Constant(6, 2.0);
    row_lower_ = Eigen::VectorXd::Constant(6, -kInf);
    row_upper_ = Eigen::VectorXd::Constant(6, kInf);
    row_lower_[0] = 0.25;
    balls_ = {{.first = 1, .count = 2, .radius = 0.5},
              {.first = 3, .count = 1, .radius = 0.1},
              {.first = 4, .count = 2, .radius = 0.0}};
  }

 private:
  void do_evaluate(const Eigen::VectorXd& v, Values& values) override {
    values.objective = v.squaredNorm();
    values.gradient = 2.0 * v;
    values.rows = v.array().square() + v[0];
    values.jacobian = (2.0 * v).asDiagonal();
    values.jacobian.col(0).array() += 1.0;
  }
  [[nodiscard]] Eigen::MatrixXd do_hessian(const Eigen::VectorXd&, double factor, const Eigen::VectorXd& y) override {
    return Eigen::MatrixXd((2.0 * y).asDiagonal()) + 2.0 * factor * Eigen::MatrixXd::Identity(6, 6);
  }
};

Eigen::VectorXd random_point(const SmoothProgram& program, unsigned seed) {
  std::mt19937 generator{seed};
  Eigen::VectorXd v(program.n_variables());
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    v[i] = std::uniform_real_distribution<double>{program.lower()[i], program.upper()[i]}(generator);
  }
  return v;
}

// Central differences of step h are off by h^2 / 6 times the third derivative (about 10 here), and by rounding / h.
void expect_derivatives_by_differences(SmoothProgram& program, const Eigen::VectorXd& v) {
  constexpr double kStep = 1e-5, kTolerance = 1e-8;
  SmoothProgram::Values here, ahead, behind;
  program.evaluate(v, here);
  Eigen::VectorXd y(program.n_rows());
  for (Eigen::Index i = 0; i < y.size(); ++i) y[i] = std::sin(1.0 + static_cast<double>(i));
  const double factor = 0.7;
  const Eigen::MatrixXd hessian = program.hessian(v, factor, y);
  for (Eigen::Index j = 0; j < v.size(); ++j) {
    Eigen::VectorXd w = v;
    w[j] = v[j] + kStep;
    program.evaluate(w, ahead);
    w[j] = v[j] - kStep;
    program.evaluate(w, behind);
    EXPECT_NEAR(here.gradient[j], (ahead.objective - behind.objective) / (2.0 * kStep), kTolerance);
    EXPECT_LE(((ahead.rows - behind.rows) / (2.0 * kStep) - here.jacobian.col(j)).lpNorm<Eigen::Infinity>(),
              kTolerance);
    const Eigen::VectorXd lagrangian_ahead = factor * ahead.gradient + ahead.jacobian.transpose() * y;
    const Eigen::VectorXd lagrangian_behind = factor * behind.gradient + behind.jacobian.transpose() * y;
    const Eigen::VectorXd column = (lagrangian_ahead - lagrangian_behind) / (2.0 * kStep);
    EXPECT_LE((column - hessian.col(j)).lpNorm<Eigen::Infinity>(), 10.0 * kTolerance);
  }
}

TEST(SmoothProgram, RefusesAPointOfAnotherSizeOrThatIsNotFinite) {
  Mixture program;
  SmoothProgram::Values values;
  EXPECT_THAT([&] { program.evaluate(Eigen::VectorXd::Zero(5), values); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("5 entries, the program 6 variables")));
  Eigen::VectorXd v = Eigen::VectorXd::Zero(6);
  v[3] = kInf;
  EXPECT_THAT([&] { program.evaluate(v, values); }, ThrowsMessage<std::invalid_argument>(HasSubstr("v[3] = inf")));
  v[3] = std::nan("");
  EXPECT_THAT([&] { (void)program.hessian(v, 1.0, Eigen::VectorXd::Zero(6)); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("v[3] = nan")));
  EXPECT_THAT([&] { (void)program.hessian(Eigen::VectorXd::Zero(6), 1.0, Eigen::VectorXd::Zero(4)); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("4 multipliers, the program has 6 rows")));
  EXPECT_THROW((void)program.violation(Eigen::VectorXd::Zero(6), Eigen::VectorXd::Zero(4)), std::invalid_argument);
}

TEST(SmoothProgram, MeasuresTheLargestViolation) {
  const Mixture program;
  Eigen::VectorXd v = Eigen::VectorXd::Zero(6), c(6);
  c << 0.25, 0.3, 0.4, 0.1, 0.0, 0.0;  // |(0.3, 0.4)| = 0.5: everything holds, with nothing to spare
  EXPECT_NEAR(program.violation(v, c), 0.0, 1e-15);
  c[0] = 0.05;
  EXPECT_NEAR(program.violation(v, c), 0.2, 1e-15);
  c[1] = 0.6, c[2] = 0.8;  // |(0.6, 0.8)| - 0.5
  EXPECT_NEAR(program.violation(v, c), 0.5, 1e-15);
  c[4] = -0.6, c[5] = 0.8;  // |(0.6, 0.8)| - 0
  EXPECT_NEAR(program.violation(v, c), 1.0, 1e-15);
  v[5] = -3.5;  // below its bound of -2
  EXPECT_NEAR(program.violation(v, c), 1.5, 1e-15);
}

TEST(SmoothProgram, CallsNotANumberAViolationWithoutBounds) {
  const Mixture program;
  Eigen::VectorXd c = Eigen::VectorXd::Constant(6, 0.0);
  c[3] = std::nan("");
  EXPECT_EQ(program.violation(Eigen::VectorXd::Zero(6), c), kInf);
}

TEST(SmoothProgram, SpreadsItsStartsOverTheBounds) {
  Mixture program;
  std::set<double> first;
  for (int k = 0; k < 32; ++k) {
    const Eigen::VectorXd v = program.start(k);
    EXPECT_EQ(v, program.start(k));
    EXPECT_TRUE((v.array() >= program.lower().array()).all() && (v.array() <= program.upper().array()).all());
    first.insert(v[0]);
  }
  EXPECT_EQ(first.size(), 32U);
  // 32 points of the base-2 sequence leave no gap above 1/16 of the interval of 4.
  double last = program.lower()[0];
  for (const double x : first) {
    EXPECT_LE(x - last, 0.25 + 1e-12);
    last = x;
  }
  EXPECT_THROW((void)program.start(-2), std::invalid_argument);
}

TEST(SmoothProgram, StartsEndlessJointsWithinATurn) {
  Mixture inner;
  Wrapped program{inner, {}};
  program.set_bounds(0, -kInf, kInf);
  program.set_bounds(1, 3.0, kInf);
  program.set_bounds(2, -kInf, -3.0);
  for (int k = 0; k < 16; ++k) {
    const Eigen::VectorXd v = program.start(k);
    EXPECT_LE(std::abs(v[0]), std::numbers::pi);
    EXPECT_GE(v[1], 3.0);
    EXPECT_LE(v[1], 3.0 + 2.0 * std::numbers::pi);
    EXPECT_LE(v[2], -3.0);
    EXPECT_GE(v[2], -3.0 - 2.0 * std::numbers::pi);
  }
}

TEST(BallsAsRows, HasAVariablePerRowOfABallAndARowPerBall) {
  Mixture inner;
  const BallsAsRows program{inner};
  EXPECT_EQ(program.n_variables(), 6 + 2 + 1);  // the ball of radius 0 needs none
  EXPECT_EQ(program.n_rows(), 6 + 1);           // |u|^2 <= 1 of the ball of two rows
  EXPECT_TRUE(program.balls().empty());
  EXPECT_EQ(program.row_lower()[0], 0.25);
  for (int i = 1; i < 6; ++i) {
    EXPECT_EQ(program.row_lower()[i], 0.0);
    EXPECT_EQ(program.row_upper()[i], 0.0);
  }
  EXPECT_EQ(program.row_upper()[6], 1.0);
  EXPECT_EQ(program.upper()[8], 1.0);
  EXPECT_EQ(program.lower()[8], -1.0);
}

TEST(BallsAsRows, DerivativesAreThoseOfDifferences) {
  Mixture mixture;
  ArmProgram arm = random_arm(4, 7);
  HockSchittkowski71 without_balls;
  for (SmoothProgram* inner : std::initializer_list<SmoothProgram*>{&mixture, &arm, &without_balls}) {
    for (unsigned seed = 0; seed < 5; ++seed) {
      expect_derivatives_by_differences(*inner, random_point(*inner, seed));
      BallsAsRows program{*inner};
      expect_derivatives_by_differences(program, random_point(program, seed));
    }
  }
}

// The same feasible set: u = c / R makes the rows of a ball hold exactly where the ball does.
TEST(BallsAsRows, IsFeasibleWhereTheInnerProgramIs) {
  ArmProgram inner = random_arm(3, 2);
  BallsAsRows program{inner};
  SmoothProgram::Values inner_values, values;
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Eigen::VectorXd v = random_point(inner, seed);
    const Eigen::VectorXd extended = program.extended(v);
    EXPECT_EQ(program.reduced(extended), v);
    inner.evaluate(v, inner_values);
    program.evaluate(extended, values);
    EXPECT_EQ(values.objective, inner_values.objective);
    const double distance = inner.violation(v, inner_values.rows);
    EXPECT_NEAR(values.rows.head(3).norm(), distance, 1e-12 * (1.0 + distance));
    EXPECT_LE(values.rows[3], 1.0 + 1e-12);
  }
}

TEST(BallsAsRows, StartsWithUInsideItsBall) {
  Mixture inner;
  BallsAsRows program{inner};
  for (int k = 0; k < 20; ++k) {
    const Eigen::VectorXd v = program.start(k);
    EXPECT_EQ(program.reduced(v), inner.start(k));
    EXPECT_LE(v.segment(6, 2).norm(), 1.0 + 1e-15);
    EXPECT_LE(std::abs(v[8]), 1.0);
  }
}

TEST(BallsAsRows, TakesRowsThatAreNotANumberForTheCentre) {
  ArmProgram arm = OneHinge::program();
  Wrapped inner = nan_beyond(arm, 0, -kInf);
  BallsAsRows program{inner};
  EXPECT_TRUE(program.extended(arm.start(0)).tail(3).isZero());
}

}  // namespace
}  // namespace modsearch::test
