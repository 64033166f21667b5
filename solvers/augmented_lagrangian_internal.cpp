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
    : program_{program},
      options_{options},
      meter_{meter},
      n_{program.n_variables()},
      m_{program.n_rows()},
      in_ball_(static_cast<std::size_t>(m_), false),
      lambda_{Eigen::VectorXd::Zero(m_)},
      rho_{rho},
      weighted_(m_, n_) {
  for (const BallRows& ball : program.balls()) std::fill_n(in_ball_.begin() + ball.first, ball.count, true);
}

bool AugmentedLagrangian::evaluate(AugmentedPoint& point) {
  ++evaluations_;
  meter_.count_program(1);
  program_.evaluate(point.v, point.values);
  augment(point);
  if (!std::isfinite(point.phi) || !point.gradient.allFinite() || !point.values.jacobian.allFinite()) return false;
  best_.offer(point.v, point.values.objective, point.violation, options_.tolerance);
  return true;
}

// Everything that depends on lambda and rho, from values that are there.
void AugmentedLagrangian::augment(AugmentedPoint& point) const {
  const Eigen::VectorXd& c = point.values.rows;
  point.excess.resize(m_);
  point.violation = 0.0;
  for (Eigen::Index i = 0; i < m_; ++i) {
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
  multipliers_ = rho_ * point.excess;
  H = program_.hessian(point.v, 1.0, multipliers_);
  if (!H.allFinite()) H.setZero(n_, n_);  // what is left is Gauss-Newton's
  for (Eigen::Index i = 0; i < m_; ++i) {
    if (in_ball_[static_cast<std::size_t>(i)]) continue;
    const bool active = point.excess[i] != 0.0 || program_.row_lower()[i] == program_.row_upper()[i];
    weighted_.row(i) = (active ? rho_ : 0.0) * J.row(i);
  }
  for (const BallRows& ball : program_.balls()) {
    const auto excess = point.excess.segment(ball.first, ball.count);
    const double outside = excess.norm();  // |y| - R
    const double across = ball.radius > 0.0 ? outside / (outside + ball.radius) : 1.0;
    const double along = outside > 0.0 ? (1.0 - across) / (outside * outside) : 0.0;
    for (Eigen::Index j = 0; j < n_; ++j) {
      const auto column = J.col(j).segment(ball.first, ball.count);
      weighted_.col(j).segment(ball.first, ball.count) = rho_ * (across * column + along * excess.dot(column) * excess);
    }
  }
  for (Eigen::Index j = 0; j < n_; ++j) {
    for (Eigen::Index i = j; i < n_; ++i) H(i, j) += J.col(i).dot(weighted_.col(j));
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
  return (point.excess - lambda_ / rho_).lpNorm<Eigen::Infinity>();
}

bool AugmentedLagrangian::nearest_to_feasible(const AugmentedPoint& point) const {
  if (point.violation <= 1e3 * options_.tolerance) return false;
  const Eigen::VectorXd& c = point.values.rows;
  Eigen::VectorXd distance = c - c.cwiseMax(program_.row_lower()).cwiseMin(program_.row_upper());
  for (const BallRows& ball : program_.balls()) {
    distance.segment(ball.first, ball.count) = c.segment(ball.first, ball.count);
    project_out_of_ball(distance.segment(ball.first, ball.count), ball.radius);
  }
  return largest(point, point.values.jacobian.transpose() * distance) <= 1e-6 * distance.norm();
}

void AugmentedLagrangian::update(AugmentedPoint& point, double rho) {
  lambda_ = rho_ * point.excess;
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
