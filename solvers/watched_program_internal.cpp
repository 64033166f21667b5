#include <cmath>
#include <modsearch/solvers/watched_program_internal.hpp>

namespace modsearch {
namespace {

bool all_numbers(const SmoothProgram::Values& values) {
  return std::isfinite(values.objective) && values.gradient.allFinite() && values.rows.allFinite() &&
         values.jacobian.allFinite();
}

}  // namespace

void BestPoint::offer(const Eigen::VectorXd& point, double its_objective, double its_violation, double tolerance) {
  const bool both_feasible = its_violation <= tolerance && violation <= tolerance;
  const bool better = both_feasible ? its_objective < objective : its_violation < violation;
  if (!better) return;
  v = point;
  objective = its_objective;
  violation = its_violation;
}

InnerResult make_result(InnerStatus status, const BestPoint& best, std::int64_t evaluations,
                        const InnerOptions& options, const Meter& meter) {
  if (status == InnerStatus::kConverged) {
    if (best.violation > options.tolerance) status = InnerStatus::kInfeasible;
  } else if (meter.stopped()) {
    status = InnerStatus::kStopped;
  }
  return {status, best.v, best.objective, best.violation, evaluations};
}

WatchedProgram::WatchedProgram(SmoothProgram& program, const InnerOptions& options, Meter& meter)
    : program_{program}, options_{options}, meter_{meter} {
  lower_ = program.lower();
  upper_ = program.upper();
  row_lower_ = program.row_lower();
  row_upper_ = program.row_upper();
  balls_ = program.balls();
}

void WatchedProgram::do_evaluate(const Eigen::VectorXd& v, Values& values) {
  // Packages leave the bounds by rounding errors, where a program need not be defined.
  inside_ = v.cwiseMax(lower_).cwiseMin(upper_);
  ++evaluations_;
  meter_.count_program(1);
  program_.evaluate(inside_, values);
  if (!all_numbers(values)) throw NotANumber{};
  best_.offer(inside_, values.objective, program_.violation(inside_, values.rows), options_.tolerance);
}

Eigen::MatrixXd WatchedProgram::do_hessian(const Eigen::VectorXd& v, double objective_factor,
                                           const Eigen::VectorXd& multipliers) {
  inside_ = v.cwiseMax(lower_).cwiseMin(upper_);
  Eigen::MatrixXd hessian = program_.hessian(inside_, objective_factor, multipliers);
  if (!hessian.allFinite()) throw NotANumber{};
  return hessian;
}

}  // namespace modsearch
