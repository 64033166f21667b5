#pragma once

#include <modsearch/problem/smooth_program.hpp>
#include <modsearch/solvers/meter.hpp>
#include <optional>
#include <string_view>
#include <vector>

namespace modsearch {

/// Packages and methods that minimise a smooth program.
enum class Inner {
  kOwn,     ///< augmented Lagrangian with projected Newton steps, this project's own; local
  kIpopt,   ///< interior point with the exact Hessian; local
  kSlsqp,   ///< NLopt: sequential quadratic programming; local
  kCobyla,  ///< NLopt: linear approximations, no derivatives, then SLSQP; local
  kDirect,  ///< NLopt: DIRECT-L, then SLSQP; global, deterministic
  kCrs2,    ///< NLopt: controlled random search, then SLSQP; global
  kIsres,   ///< NLopt: evolution strategy with constraints, then SLSQP; global
  kMlsl,    ///< NLopt: multi-level single-linkage, SLSQP inside; global
  kCeres,   ///< augmented Lagrangian on Ceres' trust region; local
};
[[nodiscard]] std::string_view name(Inner inner);
[[nodiscard]] std::optional<Inner> inner_from_name(std::string_view name);
/// All of them, in the order above.
[[nodiscard]] std::vector<Inner> inner_solvers();

struct InnerOptions {
  int max_iterations = 200;    ///< of the method; arbitrary, far above what a converging run takes (10-70)
  int max_evaluations = 5000;  ///< of the program, for methods that count those (NLopt)
  double tolerance = 1e-9;     ///< rows may be violated by this much, in their own units; so is optimality
  /// First penalty of the augmented Lagrangians (own, ceres), in units of the objective per squared unit of a row.
  /// Weak: the first steps leave the rows and cross the space, and more starts succeed (10 costs 10 points of success
  /// on arms of n = 10, 0.3 some at n = 4). Strong (1e3): a start that is nearly feasible stays where it is.
  double first_penalty = 1.0;
  std::uint64_t seed = 0;  ///< of the stochastic methods (crs2, isres, mlsl)
};

enum class InnerStatus {
  kConverged,   ///< a local optimum within the tolerances
  kLimit,       ///< iterations or evaluations are spent; `v` may still be feasible
  kInfeasible,  ///< ended at a point that violates rows
  kStopped,     ///< the meter said stop
  kFailed,      ///< the package gave up (NaN, restoration failure, ..)
};
[[nodiscard]] std::string_view name(InnerStatus status);

struct InnerResult {
  InnerStatus status = InnerStatus::kFailed;
  Eigen::VectorXd v;  ///< best point found, within the bounds
  double objective = 0.0;
  double violation = 0.0;        ///< SmoothProgram::violation at v
  std::int64_t evaluations = 0;  ///< of the program
};

/// Minimises `program` from `start` [n_variables] (global methods use it as a hint or not at all). Counts the program's
/// evaluations in `meter` and stops when it says so. NaN from the program makes a step fail, never a wrong answer; an
/// exception from the program comes out of here as it is. Ipopt runs under one process-wide lock: Debian's linear
/// solver is not thread-safe.
///
/// A program that leaves out rows is solved with those near the start, and again from the answer as long as it has
/// others to add there: the answer is one of the program with all rows. `own` and `ceres` let it grow on the way
/// instead. Limits on iterations and evaluations hold for each of these solves.
[[nodiscard]] InnerResult minimise(Inner inner, SmoothProgram& program, const Eigen::VectorXd& start,
                                   const InnerOptions& options, Meter& meter);

}  // namespace modsearch
