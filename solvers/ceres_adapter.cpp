#include <ceres/ceres.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <exception>
#include <modsearch/solvers/augmented_lagrangian_internal.hpp>
#include <utility>
#include <vector>

namespace modsearch {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// phi as a function of some of the variables, at the point where Ceres is. Exceptions of the program are kept until
/// Ceres has returned.
class PhiOfSome {
 public:
  PhiOfSome(AugmentedLagrangian& phi, std::vector<int> variables, const AugmentedPoint& here)
      : phi_{phi}, variables_{std::move(variables)}, point_{here} {}

  [[nodiscard]] int size() const { return static_cast<int>(variables_.size()); }
  [[nodiscard]] int variable(int k) const { return variables_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] AugmentedLagrangian& phi() const { return phi_; }
  [[nodiscard]] const AugmentedPoint& point() const { return point_; }
  [[nodiscard]] std::exception_ptr error() const { return error_; }
  /// The program has thrown, or the meter says stop.
  [[nodiscard]] bool halted() const { return error_ != nullptr || phi_.stopped(); }

  [[nodiscard]] std::vector<double> x() const {
    std::vector<double> x(variables_.size());
    std::transform(variables_.begin(), variables_.end(), x.begin(), [&](int i) { return point_.v[i]; });
    return x;
  }

  /// Evaluates at `x` unless that is where we are. False: there is no number.
  bool move_to(const double* x) {
    if (halted()) return false;
    bool moved = false;
    for (int k = 0; k < size(); ++k) {
      const int i = variable(k);
      if (!std::isfinite(x[k])) return false;
      const double inside = std::clamp(x[k], phi_.program().lower()[i], phi_.program().upper()[i]);
      moved = moved || point_.v[i] != inside;
      point_.v[i] = inside;
    }
    if (!moved) return is_number_;
    try {
      is_number_ = false;
      is_number_ = phi_.evaluate(point_);
    } catch (...) {
      error_ = std::current_exception();
    }
    return is_number_;
  }

  /// Gradient and second derivative (symmetric) in these variables.
  [[nodiscard]] Eigen::VectorXd gradient() const {
    Eigen::VectorXd g(size());
    for (int k = 0; k < size(); ++k) g[k] = point_.gradient[variable(k)];
    return g;
  }
  /// False: the program threw.
  [[nodiscard]] bool hessian(Eigen::MatrixXd& H) {
    try {
      phi_.hessian(point_, full_);
    } catch (...) {
      error_ = std::current_exception();
      return false;
    }
    H.resize(size(), size());
    for (int j = 0; j < size(); ++j) {
      for (int i = j; i < size(); ++i) H(i, j) = H(j, i) = full_(variable(i), variable(j));
    }
    return true;
  }

 private:
  AugmentedLagrangian& phi_;
  std::vector<int> variables_;
  AugmentedPoint point_;
  bool is_number_ = true;
  std::exception_ptr error_;
  Eigen::MatrixXd full_;
};

/// Any smooth function as half a sum of squares, for a least-squares package. Ceres uses residuals r and their Jacobian
/// A in three ways only: 1/2 |r|^2 is the cost, A^T r its gradient, A^T A its second derivative. So, at every point,
///
///   A = [ W ; 0 ],  r = [ W^-T g ; s ]   with W^T W = H, g = grad phi and s such that 1/2 |r|^2 = phi + offset:
///
/// the cost is phi, the gradient exact, and the step that of Newton's method with H, the second derivative of phi made
/// positive definite. Written as residuals in the ordinary way, f - (a value it never falls below) and the violated
/// rows, the same problem has no curvature along the rows, where arms bend, and Ceres needs hundreds of steps.
class NewtonSquares final : public ceres::CostFunction {
 public:
  /// `offset`: phi + offset is positive wherever the search may go; elsewhere a step fails.
  NewtonSquares(PhiOfSome& some, double offset) : some_{some}, offset_{offset} {
    set_num_residuals(some.size() + 1);
    mutable_parameter_block_sizes()->push_back(some.size());
  }

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    if (!some_.move_to(parameters[0])) return false;
    const Eigen::Index n = some_.size();
    const double square = 2.0 * (some_.point().phi + offset_);
    if (!(square > 0.0)) return false;
    Eigen::Map<Eigen::VectorXd> r{residuals, n + 1};
    if (jacobians == nullptr || jacobians[0] == nullptr) {  // only the cost counts
      r.setZero();
      r[n] = std::sqrt(square);
      return true;
    }
    Eigen::MatrixXd H;
    if (!some_.hessian(H)) return false;
    // Ceres steps as if there were no bounds and moves the end into them, which need not be a descent. It is one if the
    // variables held at a bound have no part in the step of the others (projected Newton, Bertsekas 1982).
    for (int j = 0; j < n; ++j) {
      if (!some_.phi().held(some_.point(), some_.point().gradient, some_.variable(j))) continue;
      const double own = H(j, j);
      H.row(j).setZero();
      H.col(j).setZero();
      H(j, j) = own;
    }
    // H = V diag(h) V^T, with |h| in place of h: the step goes downhill where phi curves downwards too.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{H};
    const double least = 1e-10 * std::max(1.0, eigen.eigenvalues().cwiseAbs().maxCoeff());
    Eigen::VectorXd root = eigen.eigenvalues().cwiseAbs().cwiseMax(least).cwiseSqrt();
    Eigen::VectorXd first = (eigen.eigenvectors().transpose() * some_.gradient()).cwiseQuotient(root);
    // Where g is so large that |W^-T g|^2 exceeds the cost, H is raised until it does not.
    const double too_large = first.squaredNorm() / (0.99 * square);
    if (too_large > 1.0) {
      root *= std::sqrt(too_large);
      first /= std::sqrt(too_large);
    }
    r.head(n) = first;
    r[n] = std::sqrt(square - first.squaredNorm());
    Eigen::Map<RowMajor> A{jacobians[0], n + 1, n};
    A.topRows(n) = root.asDiagonal() * eigen.eigenvectors().transpose();
    A.row(n).setZero();
    return true;
  }

 private:
  PhiOfSome& some_;  // Ceres calls a const function, and it moves us to another point
  double offset_;
};

/// grad phi = 0 as a system of equations. Near the minimum, where phi itself no longer changes in floating point, its
/// gradient still does.
class GradientRoot final : public ceres::CostFunction {
 public:
  explicit GradientRoot(PhiOfSome& some) : some_{some} {
    set_num_residuals(some.size());
    mutable_parameter_block_sizes()->push_back(some.size());
  }

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    if (!some_.move_to(parameters[0])) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, some_.size()) = some_.gradient();
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::MatrixXd H;
    if (!some_.hessian(H)) return false;
    Eigen::Map<RowMajor>(jacobians[0], some_.size(), some_.size()) = H;
    return true;
  }

 private:
  PhiOfSome& some_;
};

class Watch final : public ceres::IterationCallback {
 public:
  explicit Watch(const PhiOfSome& some) : some_{some} {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return some_.halted() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const PhiOfSome& some_;
};

/// Ceres' trust region with bounds: down phi as far as its value tells, then to the root of its gradient.
class CeresDescent final : public Descent {
 public:
  Outcome descend(AugmentedLagrangian& phi, AugmentedPoint& here, double omega) override {
    constexpr double kNear = 1e-3;  // with curvatures about 1, phi then is 1e-6 above its minimum
    constexpr int kRounds = 4;      // roots may lie beyond a bound, and the set of held variables changes
    int steps = 0;
    for (int round = 0; round < kRounds; ++round) {
      if (phi.projected_gradient(here) > std::max(omega, kNear)) {
        // Far enough below phi that it stays positive, near enough that small decreases are seen beside it.
        PhiOfSome some{phi, not_fixed(phi), here};
        const NewtonSquares squares{some, 10.0 * (1.0 + std::abs(here.phi)) - here.phi};
        const End end = solve(squares, some, here, std::max(omega, 0.1 * kNear), steps);
        if (end != End::kReached) return {end, steps};
      }
      if (phi.projected_gradient(here) <= omega) return {End::kReached, steps};
      PhiOfSome some{phi, not_held(phi, here), here};
      const GradientRoot root{some};
      AugmentedPoint there = here;
      const End end = solve(root, some, there, 0.0, steps);
      if (end != End::kReached) return {end, steps};
      if (!(phi.projected_gradient(there) < phi.projected_gradient(here))) return {End::kRounding, steps};
      here = there;
      if (phi.projected_gradient(here) <= omega) return {End::kReached, steps};
    }
    return {End::kNoProgress, steps};
  }

 private:
  // Ceres refuses a variable without room.
  [[nodiscard]] static std::vector<int> not_fixed(const AugmentedLagrangian& phi) {
    std::vector<int> variables;
    for (int i = 0; i < phi.program().n_variables(); ++i) {
      if (phi.program().lower()[i] < phi.program().upper()[i]) variables.push_back(i);
    }
    return variables;
  }

  [[nodiscard]] static std::vector<int> not_held(const AugmentedLagrangian& phi, const AugmentedPoint& here) {
    std::vector<int> variables = not_fixed(phi);
    std::erase_if(variables, [&](int i) { return phi.held(here, here.gradient, i); });
    return variables;
  }

  // One run of Ceres; `here` becomes the point it ends at. Throws what the program threw.
  [[nodiscard]] End solve(const ceres::CostFunction& cost, PhiOfSome& some, AugmentedPoint& here,
                          double gradient_tolerance, int& steps) {
    const AugmentedLagrangian& phi = some.phi();
    const int left = phi.options().max_iterations - iterations_;
    if (left < 1) return End::kLimit;
    std::vector<double> x = some.x();
    ceres::Problem::Options ownership;
    ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem{ownership};
    problem.AddResidualBlock(const_cast<ceres::CostFunction*>(&cost), nullptr, x.data());  // Ceres only evaluates it
    for (int k = 0; k < some.size(); ++k) {
      const double low = phi.program().lower()[some.variable(k)], high = phi.program().upper()[some.variable(k)];
      if (std::isfinite(low)) problem.SetParameterLowerBound(x.data(), k, low);
      if (std::isfinite(high)) problem.SetParameterUpperBound(x.data(), k, high);
    }
    Watch watch{some};
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    options.minimizer_progress_to_stdout = false;
    options.callbacks.push_back(&watch);
    options.max_num_iterations = left;
    options.gradient_tolerance = gradient_tolerance;
    options.function_tolerance = 1e-13;  // relative: not far above rounding errors
    options.parameter_tolerance = 1e-15;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);

    steps += std::max(0, summary.num_successful_steps - 1);  // Ceres counts the start
    iterations_ += std::max(1, static_cast<int>(summary.iterations.size()) - 1);
    if (!some.halted()) (void)some.move_to(x.data());
    if (some.error()) std::rethrow_exception(some.error());
    if (some.phi().stopped()) return End::kStopped;
    if (!summary.IsSolutionUsable()) return End::kNoProgress;
    here = some.point();
    return summary.termination_type == ceres::NO_CONVERGENCE ? End::kLimit : End::kReached;
  }

  int iterations_ = 0;
};

}  // namespace

InnerResult minimise_ceres(SmoothProgram& program, const Eigen::VectorXd& start, const InnerOptions& options,
                           Meter& meter) {
  CeresDescent descent;
  return method_of_multipliers(program, start, options, meter, descent);
}

}  // namespace modsearch
