#pragma once

#include <limits>
#include <modsearch/solvers/inner_solver.hpp>

namespace modsearch {

/// The program gave NaN: the step that led there fails.
struct NotANumber {};

/// The best point of a search so far: of those that violate nothing by more than the tolerance the one with least
/// objective, and until there is one, the one that violates least.
struct BestPoint {
  Eigen::VectorXd v;  ///< empty until a point was offered
  double objective = std::numeric_limits<double>::infinity();
  double violation = std::numeric_limits<double>::infinity();

  void offer(const Eigen::VectorXd& point, double its_objective, double its_violation, double tolerance);
};

/// The result of a search that ended with `status`; a status of converged becomes infeasible where the best point
/// violates more than the tolerance, and others become stopped where the meter has said stop.
[[nodiscard]] InnerResult make_result(InnerStatus status, const BestPoint& best, std::int64_t evaluations,
                                      const InnerOptions& options, const Meter& meter);

/// A program as a package gets to see it: points are moved into the bounds first, evaluations are counted in the meter,
/// the best point so far is remembered. `evaluate` throws NotANumber where the program is not a number; other
/// exceptions of the program come through. Adapters of packages that are not written for exceptions catch both.
class WatchedProgram final : public SmoothProgram {
 public:
  /// All three must outlive it.
  WatchedProgram(SmoothProgram& program, const InnerOptions& options, Meter& meter);

  [[nodiscard]] Design design(const Eigen::VectorXd& v) const override { return program_.design(v); }

  /// Time to stop, says the meter.
  [[nodiscard]] bool stopped() const { return meter_.stopped().has_value(); }
  [[nodiscard]] std::int64_t evaluations() const { return evaluations_; }
  [[nodiscard]] const BestPoint& best() const { return best_; }
  /// What to give back when the package ended with `status`.
  [[nodiscard]] InnerResult result(InnerStatus status) const {
    return make_result(status, best_, evaluations_, options_, meter_);
  }

 private:
  void do_evaluate(const Eigen::VectorXd& v, Values& values) override;
  [[nodiscard]] Eigen::MatrixXd do_hessian(const Eigen::VectorXd& v, double objective_factor,
                                           const Eigen::VectorXd& multipliers) override;

  SmoothProgram& program_;
  const InnerOptions& options_;
  Meter& meter_;
  BestPoint best_;
  std::int64_t evaluations_ = 0;
  Eigen::VectorXd inside_;
};

/// One function per package; `start` is within the bounds and at least one variable is free.
[[nodiscard]] InnerResult minimise_own(SmoothProgram& program, const Eigen::VectorXd& start,
                                       const InnerOptions& options, Meter& meter);
[[nodiscard]] InnerResult minimise_ipopt(SmoothProgram& program, const Eigen::VectorXd& start,
                                         const InnerOptions& options, Meter& meter);
[[nodiscard]] InnerResult minimise_nlopt(Inner inner, SmoothProgram& program, const Eigen::VectorXd& start,
                                         const InnerOptions& options, Meter& meter);
[[nodiscard]] InnerResult minimise_ceres(SmoothProgram& program, const Eigen::VectorXd& start,
                                         const InnerOptions& options, Meter& meter);

}  // namespace modsearch
