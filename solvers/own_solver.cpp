#include <algorithm>
#include <cmath>
#include <modsearch/solvers/augmented_lagrangian_internal.hpp>
#include <modsearch/solvers/free_cholesky_internal.hpp>
#include <utility>

namespace modsearch {
namespace {

constexpr double kFirstDamping = 1e-2;  // tau: arbitrary, adapts at once

/// Projected Newton (Bertsekas 1982) with the exact Hessian, damped as in Levenberg and Marquardt until the decrease is
/// what the quadratic model promised. With Gauss-Newton's part of the Hessian alone less than one start of ten
/// converges: the objective of an arm is linear, all curvature along the rows comes from the multipliers.
class ProjectedNewton final : public Descent {
 public:
  explicit ProjectedNewton(Eigen::Index n) : step_(n), cholesky_{n} { free_.reserve(static_cast<std::size_t>(n)); }

  Outcome descend(AugmentedLagrangian& phi, AugmentedPoint& here, double omega) override {
    for (int steps = 0;; ++steps) {
      if (phi.stopped()) return {End::kStopped, steps};
      const double gradient = phi.projected_gradient(here);
      if (gradient <= omega) return {End::kReached, steps};
      choose_free(phi, here);
      phi.hessian(here, hessian_);
      const End end = take_step(phi, here, gradient);
      if (end != End::kReached) return {end, steps};
    }
  }

 private:
  void choose_free(const AugmentedLagrangian& phi, const AugmentedPoint& here) {
    free_.clear();
    for (Eigen::Index i = 0; i < step_.size(); ++i) {
      if (!phi.held(here, here.gradient, i)) free_.push_back(i);
    }
  }

  // One step that decreases phi, shortened by damping as often as needed. kReached: taken.
  End take_step(AugmentedLagrangian& phi, AugmentedPoint& here, double gradient) {
    constexpr double kTooMuchDamping = 1e12;
    for (double least_damping = 1e-3; damping_ < kTooMuchDamping; damping_ = std::max(4.0 * damping_, least_damping)) {
      if (!cholesky_.factorise(hessian_, free_, damping_)) continue;
      if (iterations_++ >= phi.options().max_iterations) return End::kLimit;
      cholesky_.solve(here.gradient, step_);
      there_.v = (here.v + step_).cwiseMax(phi.program().lower()).cwiseMin(phi.program().upper());
      step_ = there_.v - here.v;
      const double predicted = predicted_decrease(here);
      // Beside phi this is a rounding error: whether phi falls is chance, whether its gradient falls is not.
      const bool tiny = std::abs(predicted) <= 1e-13 * (1.0 + std::abs(here.phi));
      if (!(predicted > 0.0) && !tiny) continue;  // the bounds cut away what made it a descent
      if (!phi.evaluate(there_)) {
        least_damping = 1.0;
        continue;
      }
      const double ratio = (here.phi - there_.phi) / predicted;
      if (tiny && !(phi.projected_gradient(there_) < gradient)) return End::kRounding;
      if (!tiny && !(ratio > 1e-3)) continue;
      if (tiny || ratio > 0.75) damping_ = damping_ < 1e-8 ? 0.0 : 0.1 * damping_;
      if (!tiny && ratio < 0.25) damping_ = std::max(4.0 * damping_, 1e-4);
      std::swap(here, there_);
      return End::kReached;
    }
    damping_ = kFirstDamping;
    return End::kNoProgress;
  }

  // What the quadratic model promises for step_.
  [[nodiscard]] double predicted_decrease(const AugmentedPoint& here) const {
    double curvature = 0.0;
    for (Eigen::Index j = 0; j < step_.size(); ++j) {
      double sum = 0.5 * hessian_(j, j) * step_[j];
      for (Eigen::Index i = j + 1; i < step_.size(); ++i) sum += hessian_(i, j) * step_[i];
      curvature += sum * step_[j];
    }
    return -here.gradient.dot(step_) - curvature;
  }

  double damping_ = kFirstDamping;  // tau
  int iterations_ = 0;
  // Storage that is used again in every step.
  AugmentedPoint there_;
  Eigen::MatrixXd hessian_;
  Eigen::VectorXd step_;
  std::vector<Eigen::Index> free_;
  FreeCholesky cholesky_;
};

}  // namespace

InnerResult minimise_own(SmoothProgram& program, const Eigen::VectorXd& start, const InnerOptions& options,
                         Meter& meter) {
  ProjectedNewton newton{program.n_variables()};
  return method_of_multipliers(program, start, options, meter, newton);
}

}  // namespace modsearch
