#include <modsearch/solvers/free_cholesky_internal.hpp>
#include <modsearch/solvers/watched_program_internal.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Constants without a name in theory come from 800 solves of random arms per size, n = 4..12 (docs/solvers.md).
constexpr double kFirstPenalty = 1.0;    // rho: weak, so that the first steps may leave the rows and cross the space;
                                         // 10 costs 10 points of success at n = 10, 0.3 some at n = 4
constexpr double kPenaltyGrowth = 4.0;   // 10 and 100 make the active bounds change too abruptly
constexpr double kLargestPenalty = 1e7;  // rho times the rounding error of c stays below 1e-8
constexpr double kGoodReduction = 0.3;   // of the multipliers' shift; with less than that, rho grows
constexpr double kFirstGradient = 0.1;   // omega: how exactly the first augmented Lagrangian is minimised
constexpr double kGradientDecrease = 0.1;
constexpr double kFirstDamping = 1e-2;   // tau: arbitrary, adapts at once

/// What the augmented Lagrangian is made of at one point.
struct Point {
  Eigen::VectorXd v;
  SmoothProgram::Values values;
  Eigen::VectorXd excess;    // y - P(y) for y = c + lambda / rho, P the projection onto intervals and balls [m]
  Eigen::VectorXd gradient;  // of the augmented Lagrangian [n]
  double phi = 0.0;          // the augmented Lagrangian, less a constant
  double violation = 0.0;    // of the rows
};

/// min f(v) with c(v) in a set S of intervals and balls, and v within bounds:
///
///   phi(v) = f + rho / 2 |y - P(y)|^2,   y = c(v) + lambda / rho,
///
/// is minimised within the bounds, then lambda <- rho (y - P(y)), and again (Hestenes 1969 and Powell 1969; Rockafellar
/// 1973 for sets). A ball is projected onto as it is, and the constraint stays smooth at its centre.
///
/// Inside: projected Newton (Bertsekas 1982) with the exact Hessian, damped as in Levenberg and Marquardt until the
/// decrease is what the quadratic model promised. With the Gauss-Newton part alone it converges in less than one start of
/// ten: the objective of an arm is linear, all curvature along the rows comes from the multipliers.
class AugmentedLagrangian {
 public:
  AugmentedLagrangian(SmoothProgram& program, const InnerOptions& options, Meter& meter)
      : program_{program},
        options_{options},
        meter_{meter},
        n_{program.n_variables()},
        m_{program.n_rows()},
        in_ball_(static_cast<std::size_t>(m_), false),
        lambda_{Eigen::VectorXd::Zero(m_)},
        weighted_(m_, n_),
        step_(n_),
        cholesky_{n_} {
    free_.reserve(static_cast<std::size_t>(n_));
    for (const BallRows& ball : program.balls()) {
      std::fill_n(in_ball_.begin() + ball.first, ball.count, true);
    }
  }

  InnerResult solve(const Eigen::VectorXd& start) {
    here_.v = start;
    if (!evaluate(here_)) return finish(InnerStatus::kFailed);
    double omega = kFirstGradient, last_shift = kInfinity;
    bool failed_before = false;
    for (;;) {
      const auto [end, steps] = descend(omega);
      if (end == Descent::kStopped) return finish(InnerStatus::kStopped);
      if (end == Descent::kLimit) return finish(InnerStatus::kLimit);

      // At a solution new and old multipliers agree; their difference bounds the violation, and how far the point is from
      // where the multipliers push.
      const double shift = multiplier_shift();
      const double gradient = projected_gradient(here_);
      if (shift <= 0.5 * options_.tolerance) {
        if (gradient <= gradient_tolerance()) return finish(InnerStatus::kConverged);
        // No better step in floating point.
        if (end == Descent::kNoProgress && gradient <= 100.0 * gradient_tolerance()) {
          return finish(InnerStatus::kConverged);
        }
      }
      if (end == Descent::kNoProgress && std::exchange(failed_before, true)) return finish(InnerStatus::kFailed);
      if (end != Descent::kNoProgress) failed_before = false;
      if (nearest_to_feasible()) return finish(InnerStatus::kInfeasible);

      lambda_ = rho_ * here_.excess;
      // A descent of one step was too easy: a larger penalty converges faster.
      if (shift > kGoodReduction * last_shift || steps <= 1) {
        if (rho_ == kLargestPenalty && shift > 0.5 * last_shift) return finish(InnerStatus::kInfeasible);
        rho_ = std::min(rho_ * kPenaltyGrowth, kLargestPenalty);
      }
      last_shift = shift;
      omega = std::max(gradient_tolerance(), kGradientDecrease * std::min(omega, 10.0 * gradient));
      augment(here_);
    }
  }

 private:
  enum class Descent { kReached, kNoProgress, kLimit, kStopped };
  struct DescentEnd {
    Descent end;
    int steps;
  };

  // Newton steps until the projected gradient is at most `omega`.
  DescentEnd descend(double omega) {
    for (int steps = 0;; ++steps) {
      if (meter_.stopped()) return {Descent::kStopped, steps};
      choose_free();
      const double gradient = projected_gradient(here_);
      if (gradient <= omega) return {Descent::kReached, steps};
      build_hessian();
      if (!take_step(gradient)) {
        return {iterations_ < options_.max_iterations ? Descent::kNoProgress : Descent::kLimit, steps};
      }
    }
  }

  // One step that decreases phi, shortened by damping as often as needed; false: none found, or out of iterations.
  bool take_step(double gradient) {
    constexpr double kTooMuchDamping = 1e12;
    for (double least_damping = 1e-3; damping_ < kTooMuchDamping; damping_ = std::max(4.0 * damping_, least_damping)) {
      if (!cholesky_.factorise(hessian_, free_, damping_)) continue;
      if (iterations_++ >= options_.max_iterations) return false;
      cholesky_.solve(here_.gradient, free_, step_);
      there_.v = (here_.v + step_).cwiseMax(program_.lower()).cwiseMin(program_.upper());
      step_ = there_.v - here_.v;
      const double predicted = predicted_decrease();
      // Beside phi this is a rounding error: whether phi falls is chance, whether its gradient falls is not.
      const bool tiny = std::abs(predicted) <= 1e-13 * (1.0 + std::abs(here_.phi));
      if (!(predicted > 0.0) && !tiny) continue;  // the bounds cut away what made it a descent
      if (!evaluate(there_)) {
        least_damping = 1.0;
        continue;
      }
      const double ratio = (here_.phi - there_.phi) / predicted;
      if (tiny && !(projected_gradient(there_) < gradient)) return false;
      if (!tiny && !(ratio > 1e-3)) continue;
      if (tiny || ratio > 0.75) damping_ = damping_ < 1e-8 ? 0.0 : 0.1 * damping_;
      if (!tiny && ratio < 0.25) damping_ = std::max(4.0 * damping_, 1e-4);
      std::swap(here_, there_);
      return true;
    }
    damping_ = kFirstDamping;
    return false;
  }

  // False: not a number.
  bool evaluate(Point& point) {
    ++evaluations_;
    meter_.count_program(1);
    program_.evaluate(point.v, point.values);
    augment(point);
    if (!std::isfinite(point.phi) || !point.gradient.allFinite() || !point.values.jacobian.allFinite()) return false;
    best_.offer(point.v, point.values.objective, point.violation, options_.tolerance);
    return true;
  }

  // Everything that depends on lambda and rho, from values that are there.
  void augment(Point& point) const {
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
      const double norm = excess.norm();
      excess *= norm > ball.radius ? 1.0 - ball.radius / norm : 0.0;
      point.violation = std::max(point.violation, rows.norm() - ball.radius);
    }
    point.phi = point.values.objective + 0.5 * rho_ * point.excess.squaredNorm();
    point.gradient = point.values.gradient;
    for (Eigen::Index j = 0; j < n_; ++j) {
      point.gradient[j] += rho_ * point.values.jacobian.col(j).dot(point.excess);
    }
  }

  // Second derivative of phi at here_, lower triangle: that of the Lagrangian at lambda = rho (y - P(y)), and
  // rho J^T (I - dP/dy) J. On the outside of a ball of radius R, with n = y / |y|,
  // I - dP/dy = n n^T + (1 - R / |y|) (I - n n^T).
  void build_hessian() {
    const Eigen::MatrixXd& J = here_.values.jacobian;
    multipliers_ = rho_ * here_.excess;
    hessian_ = program_.hessian(here_.v, 1.0, multipliers_);
    if (!hessian_.allFinite()) hessian_.setZero(n_, n_);  // what is left is Gauss-Newton's
    for (Eigen::Index i = 0; i < m_; ++i) {
      if (in_ball_[static_cast<std::size_t>(i)]) continue;
      const bool active = here_.excess[i] != 0.0 || program_.row_lower()[i] == program_.row_upper()[i];
      weighted_.row(i) = (active ? rho_ : 0.0) * J.row(i);
    }
    for (const BallRows& ball : program_.balls()) {
      const auto excess = here_.excess.segment(ball.first, ball.count);
      const double outside = excess.norm();  // |y| - R
      const double across = ball.radius > 0.0 ? outside / (outside + ball.radius) : 1.0;
      const double along = outside > 0.0 ? (1.0 - across) / (outside * outside) : 0.0;
      for (Eigen::Index j = 0; j < n_; ++j) {
        const auto column = J.col(j).segment(ball.first, ball.count);
        weighted_.col(j).segment(ball.first, ball.count) =
            rho_ * (across * column + along * excess.dot(column) * excess);
      }
    }
    for (Eigen::Index j = 0; j < n_; ++j) {
      for (Eigen::Index i = j; i < n_; ++i) hessian_(i, j) += J.col(i).dot(weighted_.col(j));
    }
  }

  // What the quadratic model promises for step_.
  [[nodiscard]] double predicted_decrease() const {
    double curvature = 0.0;
    for (Eigen::Index j = 0; j < n_; ++j) {
      double sum = 0.5 * hessian_(j, j) * step_[j];
      for (Eigen::Index i = j + 1; i < n_; ++i) sum += hessian_(i, j) * step_[i];
      curvature += sum * step_[j];
    }
    return -here_.gradient.dot(step_) - curvature;
  }

  // A variable at a bound against which g pushes it.
  [[nodiscard]] bool held(const Point& point, const Eigen::VectorXd& g, Eigen::Index i) const {
    return (point.v[i] <= program_.lower()[i] && g[i] >= 0.0) || (point.v[i] >= program_.upper()[i] && g[i] <= 0.0);
  }

  void choose_free() {
    free_.clear();
    for (Eigen::Index i = 0; i < n_; ++i) {
      if (!held(here_, here_.gradient, i)) free_.push_back(i);
    }
  }

  [[nodiscard]] double largest_free(const Point& point, const Eigen::VectorXd& g) const {
    double largest = 0.0;
    for (Eigen::Index i = 0; i < n_; ++i) {
      if (!held(point, g, i)) largest = std::max(largest, std::abs(g[i]));
    }
    return largest;
  }

  [[nodiscard]] double projected_gradient(const Point& point) const { return largest_free(point, point.gradient); }

  [[nodiscard]] double gradient_tolerance() const {
    return options_.tolerance * (1.0 + lambda_.lpNorm<Eigen::Infinity>());
  }

  // Largest change of lambda / rho that the multiplier step would make.
  [[nodiscard]] double multiplier_shift() const {
    return (here_.excess - lambda_ / rho_).lpNorm<Eigen::Infinity>();
  }

  // The distance of c from its set cannot be made smaller from here, to first order, and is not zero.
  [[nodiscard]] bool nearest_to_feasible() {
    if (here_.violation <= 1e3 * options_.tolerance) return false;
    const Eigen::VectorXd& c = here_.values.rows;
    Eigen::VectorXd distance = c - c.cwiseMax(program_.row_lower()).cwiseMin(program_.row_upper());
    for (const BallRows& ball : program_.balls()) {
      const auto rows = c.segment(ball.first, ball.count);
      const double norm = rows.norm();
      distance.segment(ball.first, ball.count) = (norm > ball.radius ? 1.0 - ball.radius / norm : 0.0) * rows;
    }
    return largest_free(here_, here_.values.jacobian.transpose() * distance) <= 1e-6 * distance.norm();
  }

  [[nodiscard]] InnerResult finish(InnerStatus status) const {
    return make_result(status, best_, evaluations_, options_, meter_);
  }

  SmoothProgram& program_;
  const InnerOptions& options_;
  Meter& meter_;
  Eigen::Index n_, m_;
  std::vector<bool> in_ball_;

  Eigen::VectorXd lambda_;
  double rho_ = kFirstPenalty;
  double damping_ = kFirstDamping;  // tau
  int iterations_ = 0;
  std::int64_t evaluations_ = 0;
  BestPoint best_;

  // Storage that is used again in every step.
  Point here_, there_;
  Eigen::VectorXd multipliers_;
  Eigen::MatrixXd hessian_, weighted_;  // weighted_ = rho (I - dP/dy) J
  Eigen::VectorXd step_;
  std::vector<Eigen::Index> free_;
  FreeCholesky cholesky_;
};

}  // namespace

InnerResult minimise_own(SmoothProgram& program, const Eigen::VectorXd& start, const InnerOptions& options,
                         Meter& meter) {
  return AugmentedLagrangian{program, options, meter}.solve(start);
}

}  // namespace modsearch
