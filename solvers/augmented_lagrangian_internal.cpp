#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/solvers/augmented_lagrangian_internal.hpp>
#include <utility>

namespace modsearch {
namespace {

// Constants without a name in theory come from 800 solves of random arms per size, n = 4..12 (docs/solvers.md).
constexpr double kPenaltyGrowth = 4.0;   // 10 and 100 make the active bounds change too abruptly
constexpr double kLargestPenalty = 1e7;  // rho times the rounding error of c stays below 1e-8
constexpr double kGoodReduction = 0.3;   // of the multipliers' shift; with less than that, rho grows
constexpr double kFirstGradient = 0.1;   // omega: how exactly the first augmented Lagrangian is minimised
constexpr double kGradientDecrease = 0.1;

// y - P(y) for a ball, in place.
template <typename Vector>
void project_out_of_ball(Vector&& y, double radius) {
  const double norm = y.norm();
  y *= norm > radius ? 1.0 - radius / norm : 0.0;
}

}  // namespace

AugmentedLagrangian::AugmentedLagrangian(SmoothProgram& program, const InnerOptions& options, Meter& meter, double rho)
    : program_{program}, options_{options}, meter_{meter}, n_{program.n_variables()}, rho_{rho} {
  fit_rows();
  for (const BallRows& ball : program.balls()) std::fill_n(in_ball_.begin() + ball.first, ball.count, true);
}

// Rows that the program got lately have no multiplier yet.
void AugmentedLagrangian::fit_rows() {
  const Eigen::Index before = lambda_.size(), m = program_.n_rows();
  lambda_.conservativeResize(m);
  if (m > before) lambda_.tail(m - before).setZero();
  in_ball_.resize(static_cast<std::size_t>(m), false);
}

bool AugmentedLagrangian::evaluate(AugmentedPoint& point) {
  ++evaluations_;
  meter_.count_program(1);
  if (program_.grow(point.v) > 0) fit_rows();
  program_.evaluate(point.v, point.values);
  augment(point);
  if (!std::isfinite(point.phi) || !point.gradient.allFinite() || !point.values.jacobian.allFinite()) return false;
  best_.offer(point.v, point.values.objective, point.violation, options_.tolerance);
  return true;
}

// Everything that depends on lambda and rho, from values that are there.
void AugmentedLagrangian::augment(AugmentedPoint& point) const {
  const Eigen::VectorXd& c = point.values.rows;
  point.excess.resize(c.size());
  point.violation = 0.0;
  for (Eigen::Index i = 0; i < c.size(); ++i) {
    const double low = program_.row_lower()[i], high = program_.row_upper()[i];
    const double y = c[i] + lambda_[i] / rho_;
    point.excess[i] = y - std::clamp(y, low, high);
    point.violation = std::max({point.violation, low - c[i], c[i] - high});
  }
  for (const BallRows& ball : program_.balls()) {
    const auto rows = c.segment(ball.first, ball.count);
    auto excess = point.excess.segment(ball.first, ball.count);
    excess = rows + lambda_.segment(ball.first, ball.count) / rho_;
    project_out_of_ball(excess, ball.radius);
    point.violation = std::max(point.violation, rows.norm() - ball.radius);
  }
  point.phi = point.values.objective + 0.5 * rho_ * point.excess.squaredNorm();
  point.gradient = point.values.gradient;
  for (Eigen::Index j = 0; j < n_; ++j) {
    point.gradient[j] += rho_ * point.values.jacobian.col(j).dot(point.excess);
  }
}

// Outside a ball of radius R, with n = y / |y|: I - dP/dy = n n^T + (1 - R / |y|) (I - n n^T).
void AugmentedLagrangian::hessian(const AugmentedPoint& point, Eigen::MatrixXd& H) {
  const Eigen::MatrixXd& J = point.values.jacobian;
  multipliers_.setZero(lambda_.size());
  multipliers_.head(point.excess.size()) = rho_ * point.excess;
  H = program_.hessian(point.v, 1.0, multipliers_);
  if (!H.allFinite()) H.setZero(n_, n_);  // what is left is Gauss-Newton's
  for (const BallRows& ball : program_.balls()) {
    const auto excess = point.excess.segment(ball.first, ball.count);
    const double outside = excess.norm();  // |y| - R
    if (outside == 0.0 && ball.radius > 0.0) continue;
    const double across = ball.radius > 0.0 ? outside / (outside + ball.radius) : 1.0;
    const double along = outside > 0.0 ? (1.0 - across) / (outside * outside) : 0.0;
    const auto rows = J.middleRows(ball.first, ball.count);
    weighted_.resize(ball.count, n_);
    for (Eigen::Index j = 0; j < n_; ++j) {
      const auto column = rows.col(j);
      weighted_.col(j) = rho_ * (across * column + along * excess.dot(column) * excess);
    }
    // Not those of other goals.
    variables_.clear();
    for (Eigen::Index j = 0; j < n_; ++j) {
      if (!rows.col(j).isZero(0.0)) variables_.push_back(j);
    }
    for (std::size_t b = 0; b < variables_.size(); ++b) {
      for (std::size_t a = b; a < variables_.size(); ++a) {
        H(variables_[a], variables_[b]) += rows.col(variables_[a]).dot(weighted_.col(variables_[b]));
      }
    }
  }
  for (Eigen::Index row = 0; row < point.excess.size(); ++row) {
    const bool active = point.excess[row] != 0.0 || program_.row_lower()[row] == program_.row_upper()[row];
    if (!active || in_ball_[static_cast<std::size_t>(row)]) continue;
    variables_.clear();
    for (Eigen::Index j = 0; j < n_; ++j) {
      if (J(row, j) != 0.0) variables_.push_back(j);
    }
    for (std::size_t b = 0; b < variables_.size(); ++b) {
      const double slope = rho_ * J(row, variables_[b]);
      for (std::size_t a = b; a < variables_.size(); ++a)
        H(variables_[a], variables_[b]) += J(row, variables_[a]) * slope;
    }
  }
}

double AugmentedLagrangian::largest(const AugmentedPoint& point, const Eigen::VectorXd& g) const {
  double result = 0.0;
  for (Eigen::Index i = 0; i < n_; ++i) {
    if (!held(point, g, i)) result = std::max(result, std::abs(g[i]));
  }
  return result;
}

double AugmentedLagrangian::gradient_tolerance() const {
  return options_.tolerance * (1.0 + lambda_.lpNorm<Eigen::Infinity>());
}

double AugmentedLagrangian::shift(const AugmentedPoint& point) const {
  return (point.excess - lambda_.head(point.excess.size()) / rho_).lpNorm<Eigen::Infinity>();
}

bool AugmentedLagrangian::nearest_to_feasible(const AugmentedPoint& point) const {
  if (point.violation <= 1e3 * options_.tolerance) return false;
  const Eigen::VectorXd& c = point.values.rows;
  Eigen::VectorXd distance =
      c - c.cwiseMax(program_.row_lower().head(c.size())).cwiseMin(program_.row_upper().head(c.size()));
  for (const BallRows& ball : program_.balls()) {
    distance.segment(ball.first, ball.count) = c.segment(ball.first, ball.count);
    project_out_of_ball(distance.segment(ball.first, ball.count), ball.radius);
  }
  return largest(point, point.values.jacobian.transpose() * distance) <= 1e-6 * distance.norm();
}

void AugmentedLagrangian::update(AugmentedPoint& point, double rho) {
  lambda_.head(point.excess.size()) = rho_ * point.excess;
  rho_ = rho;
  augment(point);
}

InnerResult method_of_multipliers(SmoothProgram& program, const Eigen::VectorXd& start, const InnerOptions& options,
                                  Meter& meter, Descent& descent) {
  AugmentedLagrangian phi{program, options, meter, options.first_penalty};
  AugmentedPoint here;
  here.v = start;
  if (!phi.evaluate(here)) return phi.result(InnerStatus::kFailed);
  double omega = kFirstGradient, last_shift = std::numeric_limits<double>::infinity();
  bool stuck_before = false;
  for (;;) {
    const auto [end, steps] = descent.descend(phi, here, omega);
    if (end == Descent::End::kStopped) return phi.result(InnerStatus::kStopped);
    if (end == Descent::End::kLimit) return phi.result(InnerStatus::kLimit);
    const double shift = phi.shift(here), gradient = phi.projected_gradient(here);
    const bool minimal = end == Descent::End::kRounding || gradient <= phi.gradient_tolerance();
    if (shift <= 0.5 * options.tolerance && minimal) return phi.result(InnerStatus::kConverged);
    const bool stuck = end == Descent::End::kNoProgress;
    if (stuck && std::exchange(stuck_before, true)) return phi.result(InnerStatus::kFailed);
    if (!stuck) stuck_before = false;
    if (phi.nearest_to_feasible(here)) return phi.result(InnerStatus::kInfeasible);

    double rho = phi.rho();
    // A descent of one step was too easy: a larger penalty converges faster.
    if (shift > kGoodReduction * last_shift || steps <= 1) {
      if (rho == kLargestPenalty && shift > 0.5 * last_shift) return phi.result(InnerStatus::kInfeasible);
      rho = std::min(rho * kPenaltyGrowth, kLargestPenalty);
    }
    last_shift = shift;
    omega = std::max(phi.gradient_tolerance(), kGradientDecrease * std::min(omega, 10.0 * gradient));
    phi.update(here, rho);
  }
}

}  // namespace modsearch
