#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/kinematics/low_discrepancy.hpp>
#include <modsearch/problem/smooth_program.hpp>
#include <numbers>
#include <stdexcept>

namespace modsearch {
namespace {

void check_point(const char* function, const Eigen::VectorXd& v, int n_variables) {
  if (v.size() != n_variables) {
    throw std::invalid_argument(
        fmt::format("SmoothProgram::{}: v has {} entries, the program {} variables", function, v.size(), n_variables));
  }
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    if (!std::isfinite(v[i])) {
      throw std::invalid_argument(fmt::format("SmoothProgram::{}: v[{}] = {} is not finite", function, i, v[i]));
    }
  }
}

// A ball of radius 0 is a point: its rows become equalities, without variables of their own.
bool needs_variables(const BallRows& ball) { return ball.radius > 0.0; }

// |u|^2 <= 1 says nothing beyond -1 <= u <= 1 if u is a single number.
bool needs_row(const BallRows& ball) { return needs_variables(ball) && ball.count > 1; }

}  // namespace

void SmoothProgram::evaluate(const Eigen::VectorXd& v, Values& values) {
  check_point("evaluate", v, n_variables());
  do_evaluate(v, values);
}

Eigen::MatrixXd SmoothProgram::hessian(const Eigen::VectorXd& v, double objective_factor,
                                       const Eigen::VectorXd& multipliers) {
  check_point("hessian", v, n_variables());
  if (multipliers.size() != n_rows()) {
    throw std::invalid_argument(
        fmt::format("SmoothProgram::hessian: {} multipliers, the program has {} rows", multipliers.size(), n_rows()));
  }
  return do_hessian(v, objective_factor, multipliers);
}

int SmoothProgram::grow(const Eigen::VectorXd& v) {
  check_point("grow", v, n_variables());
  return do_grow(v);
}

double SmoothProgram::violation(const Eigen::VectorXd& v, const Eigen::VectorXd& c) const {
  if (v.size() != n_variables() || c.size() != n_rows()) {
    throw std::invalid_argument(fmt::format("SmoothProgram::violation: v has {} entries of {}, c {} of {}", v.size(),
                                            n_variables(), c.size(), n_rows()));
  }
  // NaN compares false with everything: it would pass for feasible.
  if (!v.allFinite() || c.hasNaN()) return std::numeric_limits<double>::infinity();
  double worst = 0.0;
  for (Eigen::Index i = 0; i < v.size(); ++i) worst = std::max({worst, lower_[i] - v[i], v[i] - upper_[i]});
  for (Eigen::Index i = 0; i < c.size(); ++i) worst = std::max({worst, row_lower_[i] - c[i], c[i] - row_upper_[i]});
  for (const BallRows& ball : balls_) worst = std::max(worst, c.segment(ball.first, ball.count).norm() - ball.radius);
  return worst;
}

Eigen::VectorXd SmoothProgram::start(int index) {
  // Point 0 of the sequence is the centre of the box, where all joints of a typical arm are 0: a stretched, singular
  // posture in which first derivatives vanish. So the starts begin behind it.
  const Eigen::VectorXd cube = halton(index + 1, n_variables());
  Eigen::VectorXd v(n_variables());
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    // An endless joint starts within one turn.
    double low = lower_[i], high = upper_[i];
    if (std::isinf(low) && std::isinf(high)) low = -std::numbers::pi;
    if (std::isinf(low)) low = high - 2.0 * std::numbers::pi;
    if (std::isinf(high)) high = low + 2.0 * std::numbers::pi;
    v[i] = std::clamp(low + cube[i] * (high - low), lower_[i], upper_[i]);
  }
  return v;
}

BallsAsRows::BallsAsRows(SmoothProgram& inner) : inner_{inner} {
  int n = inner.n_variables();
  int m = inner.n_rows();
  for (const BallRows& ball : inner.balls()) {
    if (needs_variables(ball)) n += ball.count;
    if (needs_row(ball)) ++m;
  }
  lower_ = Eigen::VectorXd::Constant(n, -1.0);
  upper_ = Eigen::VectorXd::Constant(n, 1.0);
  lower_.head(inner.n_variables()) = inner.lower();
  upper_.head(inner.n_variables()) = inner.upper();
  row_lower_ = Eigen::VectorXd::Constant(m, -std::numeric_limits<double>::infinity());
  row_upper_ = Eigen::VectorXd::Ones(m);
  row_lower_.head(inner.n_rows()) = inner.row_lower();
  row_upper_.head(inner.n_rows()) = inner.row_upper();
  for (const BallRows& ball : inner.balls()) {
    row_lower_.segment(ball.first, ball.count).setZero();
    row_upper_.segment(ball.first, ball.count).setZero();
  }
}

Eigen::VectorXd BallsAsRows::extended(const Eigen::VectorXd& inner_point) {
  inner_.evaluate(inner_point, inner_values_);
  Eigen::VectorXd v(n_variables());
  v.head(inner_.n_variables()) = inner_point;
  Eigen::Index next = inner_.n_variables();
  for (const BallRows& ball : inner_.balls()) {
    if (!needs_variables(ball)) continue;
    const Eigen::VectorXd u = inner_values_.rows.segment(ball.first, ball.count) / ball.radius;
    const double norm = u.stableNorm();
    // Rows that are not numbers (the program may be undefined here) leave u at the centre of its ball.
    if (!std::isfinite(norm)) {
      v.segment(next, ball.count).setZero();
    } else {
      v.segment(next, ball.count) = norm > 1.0 ? Eigen::VectorXd(u / norm) : u;
    }
    next += ball.count;
  }
  return v;
}

Eigen::VectorXd BallsAsRows::reduced(const Eigen::VectorXd& v) const { return v.head(inner_.n_variables()); }

Eigen::VectorXd BallsAsRows::start(int index) { return extended(inner_.start(index)); }

Design BallsAsRows::design(const Eigen::VectorXd& v) const { return inner_.design(reduced(v)); }

void BallsAsRows::do_evaluate(const Eigen::VectorXd& v, Values& values) {
  const Eigen::Index n = inner_.n_variables(), m = inner_.n_rows();
  inner_.evaluate(v.head(n), inner_values_);
  values.objective = inner_values_.objective;
  values.gradient.setZero(n_variables());
  values.gradient.head(n) = inner_values_.gradient;
  values.rows.setZero(n_rows());
  values.rows.head(m) = inner_values_.rows;
  values.jacobian.setZero(n_rows(), n_variables());
  values.jacobian.topLeftCorner(m, n) = inner_values_.jacobian;
  Eigen::Index next = n, row = m;
  for (const BallRows& ball : inner_.balls()) {
    if (!needs_variables(ball)) continue;
    const auto u = v.segment(next, ball.count);
    values.rows.segment(ball.first, ball.count) -= ball.radius * u;
    values.jacobian.block(ball.first, next, ball.count, ball.count).diagonal().setConstant(-ball.radius);
    if (needs_row(ball)) {
      values.rows[row] = u.squaredNorm();
      values.jacobian.block(row, next, 1, ball.count) = 2.0 * u.transpose();
      ++row;
    }
    next += ball.count;
  }
}

Eigen::MatrixXd BallsAsRows::do_hessian(const Eigen::VectorXd& v, double objective_factor,
                                        const Eigen::VectorXd& multipliers) {
  const Eigen::Index n = inner_.n_variables(), m = inner_.n_rows();
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n_variables(), n_variables());
  result.topLeftCorner(n, n) = inner_.hessian(v.head(n), objective_factor, multipliers.head(m));
  Eigen::Index next = n, row = m;
  for (const BallRows& ball : inner_.balls()) {
    if (!needs_variables(ball)) continue;
    if (needs_row(ball))
      result.block(next, next, ball.count, ball.count).diagonal().setConstant(2.0 * multipliers[row++]);
    next += ball.count;
  }
  return result;
}

}  // namespace modsearch
