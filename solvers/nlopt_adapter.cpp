#include <fmt/format.h>
#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <modsearch/solvers/watched_program_internal.hpp>
#include <mutex>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace modsearch {
namespace {

// Stands for "not a number": worse than any value, yet finite, so that line searches can interpolate.
constexpr double kBarrier = 1e10;

/// Weights of violations in the objective of methods that know no constraints. Both arbitrary, but far above the
/// multipliers of lengths against positions (about 1), as an exact penalty has to be.
constexpr double kLinearWeight = 30.0;
constexpr double kQuadraticWeight = 1e4;

/// How a method gets to see the constraints.
enum class Form {
  kRows,              ///< as constraints
  kLinearPenalty,     ///< f + weight * (sum of violations): exact, with kinks
  kQuadraticPenalty,  ///< f + weight / 2 * (sum of squared violations): smooth, ends a little outside
};

struct Free {
  void operator()(nlopt_opt opt) const { nlopt_destroy(opt); }
};
using Opt = std::unique_ptr<std::remove_pointer_t<nlopt_opt>, Free>;

Opt make(nlopt_algorithm algorithm, int n) {
  Opt opt{nlopt_create(algorithm, static_cast<unsigned>(n))};
  if (!opt) throw std::runtime_error{fmt::format("NLopt cannot create {}", nlopt_algorithm_name(algorithm))};
  return opt;
}

/// One row, seen as value <= 0 or value = 0.
struct Side {
  Eigen::Index row;
  double sign;  // +1: c - limit, -1: limit - c
  double limit;
};

/// The program in NLopt's terms. NLopt is C: no exception may leave a callback. It is kept, the package told to stop,
/// and thrown again afterwards.
class Problem {
 public:
  Problem(WatchedProgram& watched, SmoothProgram& program, Form form)
      : watched_{watched}, program_{program}, form_{form} {
    for (Eigen::Index i = 0; i < program.n_rows(); ++i) {
      const double low = program.row_lower()[i], high = program.row_upper()[i];
      if (low == high) {
        equalities_.push_back({i, 1.0, low});
        continue;
      }
      if (std::isfinite(low)) inequalities_.push_back({i, -1.0, low});
      if (std::isfinite(high)) inequalities_.push_back({i, 1.0, high});
    }
  }

  /// Runs `opt` from `x`, which becomes the point it ends at. Throws what the program threw.
  nlopt_result run(const Opt& opt, Eigen::VectorXd& x, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                   std::int64_t max_evaluations, double tolerance) {
    opt_ = opt.get();
    nlopt_set_lower_bounds(opt_, lower.data());
    nlopt_set_upper_bounds(opt_, upper.data());
    nlopt_set_min_objective(opt_, objective, this);
    if (form_ == Form::kRows) add_constraints(tolerance);
    nlopt_set_maxeval(opt_, static_cast<int>(std::max<std::int64_t>(1, max_evaluations)));
    x = x.cwiseMax(lower).cwiseMin(upper);
    double value = 0.0;
    const nlopt_result result = nlopt_optimize(opt_, x.data(), &value);
    opt_ = nullptr;
    if (error_) std::rethrow_exception(error_);
    if (result == NLOPT_OUT_OF_MEMORY) throw std::bad_alloc{};
    if (result == NLOPT_INVALID_ARGS) {
      throw std::runtime_error{"NLopt refuses our arguments: is another version installed?"};
    }
    return result;
  }

 private:
  [[nodiscard]] std::size_t n_inequalities() const { return inequalities_.size() + program_.balls().size(); }

  void add_constraints(double tolerance) {
    const std::vector<double> slack(std::max(equalities_.size(), n_inequalities()), tolerance);
    if (!equalities_.empty()) {
      nlopt_add_equality_mconstraint(opt_, static_cast<unsigned>(equalities_.size()), equalities, this, slack.data());
    }
    if (n_inequalities() > 0) {
      nlopt_add_inequality_mconstraint(opt_, static_cast<unsigned>(n_inequalities()), inequalities, this, slack.data());
    }
  }

  // Evaluates at x unless that is where we are; false: no value is to be had.
  bool move_to(const double* x) noexcept {
    try {
      if (error_ || watched_.stopped()) {
        nlopt_force_stop(opt_);
        return false;
      }
      const Eigen::Map<const Eigen::VectorXd> point{x, program_.n_variables()};
      if (point_.size() == point.size() && point_ == point) return is_number_;
      is_number_ = false;
      if (!point.allFinite()) return false;  // some methods step to NaN after a singular solve
      point_ = point;
      program_.evaluate(point_, values_);
      is_number_ = true;
    } catch (const NotANumber&) {
    } catch (...) {
      error_ = std::current_exception();
      nlopt_force_stop(opt_);
    }
    return is_number_;
  }

  [[nodiscard]] double value(const Side& side) const { return side.sign * (values_.rows[side.row] - side.limit); }

  static double objective(unsigned n, const double* x, double* gradient, void* data) {
    Problem& self = *static_cast<Problem*>(data);
    const bool is_number = self.move_to(x);
    Eigen::Map<Eigen::VectorXd> g{gradient, gradient == nullptr ? 0 : static_cast<Eigen::Index>(n)};
    if (!is_number) {
      g.setZero();
      return kBarrier;
    }
    g = self.values_.gradient.head(g.size());
    return self.values_.objective + self.penalty(g);
  }

  // Penalty at the present point; its gradient is added to g unless that is empty.
  double penalty(Eigen::Map<Eigen::VectorXd>& g) const {
    double sum = 0.0;
    const auto add = [&](double excess, const auto& direction) {
      if (form_ == Form::kLinearPenalty) {
        sum += kLinearWeight * excess;
        if (g.size() > 0) g += kLinearWeight * direction;
      } else {
        sum += 0.5 * kQuadraticWeight * excess * excess;
        if (g.size() > 0) g += kQuadraticWeight * excess * direction;
      }
    };
    if (form_ == Form::kRows) return 0.0;
    for (const Side& side : inequalities_) {
      if (value(side) > 0.0) add(value(side), side.sign * values_.jacobian.row(side.row).transpose());
    }
    for (const Side& side : equalities_) {
      const double sign = value(side) < 0.0 ? -1.0 : 1.0;
      add(sign * value(side), sign * values_.jacobian.row(side.row).transpose());
    }
    for (const BallRows& ball : program_.balls()) {
      const auto c = values_.rows.segment(ball.first, ball.count);
      const double norm = c.norm();
      if (norm <= ball.radius) continue;
      add(norm - ball.radius, values_.jacobian.middleRows(ball.first, ball.count).transpose() * c / norm);
    }
    return sum;
  }

  static void equalities(unsigned m, double* result, unsigned n, const double* x, double* gradient, void* data) {
    Problem& self = *static_cast<Problem*>(data);
    self.rows(self.equalities_, false, m, result, n, x, gradient);
  }

  static void inequalities(unsigned m, double* result, unsigned n, const double* x, double* gradient, void* data) {
    Problem& self = *static_cast<Problem*>(data);
    self.rows(self.inequalities_, true, m, result, n, x, gradient);
  }

  void rows(const std::vector<Side>& sides, bool with_balls, unsigned m, double* result, unsigned n, const double* x,
            double* gradient) {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> g{gradient, gradient == nullptr ? 0 : static_cast<Eigen::Index>(m),
                           static_cast<Eigen::Index>(n)};
    if (!move_to(x)) {
      std::fill_n(result, m, kBarrier);
      g.setZero();
      return;
    }
    Eigen::Index k = 0;
    for (const Side& side : sides) {
      result[k] = value(side);
      if (g.rows() > 0) g.row(k) = side.sign * values_.jacobian.row(side.row);
      ++k;
    }
    if (!with_balls) return;
    for (const BallRows& ball : program_.balls()) {
      const auto c = values_.rows.segment(ball.first, ball.count);
      const double norm = c.norm();
      result[k] = norm - ball.radius;
      if (g.rows() > 0) {
        g.row(k).setZero();
        if (norm > 0.0) g.row(k) = c.transpose() / norm * values_.jacobian.middleRows(ball.first, ball.count);
      }
      ++k;
    }
  }

  WatchedProgram& watched_;
  SmoothProgram& program_;
  Form form_;
  std::vector<Side> equalities_, inequalities_;
  nlopt_opt opt_ = nullptr;
  std::exception_ptr error_;
  Eigen::VectorXd point_;
  SmoothProgram::Values values_;
  bool is_number_ = false;
};

InnerStatus status_of(nlopt_result result) {
  switch (result) {
    case NLOPT_SUCCESS:
    case NLOPT_STOPVAL_REACHED:
    case NLOPT_FTOL_REACHED:
    case NLOPT_XTOL_REACHED:
      return InnerStatus::kConverged;
    case NLOPT_MAXEVAL_REACHED:
    case NLOPT_MAXTIME_REACHED:
      return InnerStatus::kLimit;
    case NLOPT_FORCED_STOP:
      return InnerStatus::kStopped;
    default:
      return InnerStatus::kFailed;
  }
}

/// SLSQP from a point of the program itself. It may give up for rounding errors, when its quasi-Newton matrix has gone
/// astray, or end a little outside the rows. So it is started afresh from where it came, as long as that helps; if it
/// gives up again without having found anything better, steepest descent along the constraints leads nowhere: an
/// optimum.
nlopt_result slsqp(WatchedProgram& watched, Eigen::VectorXd point, const InnerOptions& options) {
  constexpr int kAttempts = 3;
  BallsAsRows intervals{watched};
  nlopt_result result = NLOPT_FAILURE;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const std::int64_t left = options.max_evaluations - watched.evaluations();
    if (left < 1) return NLOPT_MAXEVAL_REACHED;
    Eigen::VectorXd x;
    try {
      x = intervals.extended(point);
    } catch (const NotANumber&) {
      return NLOPT_FAILURE;
    }
    const BestPoint before = watched.best();
    const Opt opt = make(NLOPT_LD_SLSQP, intervals.n_variables());
    nlopt_set_xtol_rel(opt.get(), 0.0);
    nlopt_set_ftol_abs(opt.get(), 1e-3 * options.tolerance);
    nlopt_set_xtol_abs1(opt.get(), 1e-3 * options.tolerance);
    Problem problem{watched, intervals, Form::kRows};
    result = problem.run(opt, x, intervals.lower(), intervals.upper(), left, 0.25 * options.tolerance);
    if (result == NLOPT_FORCED_STOP || result == NLOPT_MAXEVAL_REACHED) return result;
    const bool gave_up = result == NLOPT_ROUNDOFF_LIMITED || result == NLOPT_FAILURE;
    const bool feasible = watched.best().violation <= options.tolerance;
    if (feasible && !gave_up) return result;
    if (attempt > 0 && before.objective - watched.best().objective <= options.tolerance &&
        watched.best().violation > 0.5 * before.violation) {
      return NLOPT_XTOL_REACHED;
    }
    point = intervals.reduced(x);
  }
  return result;
}

/// COBYLA with four fifths of the evaluations, then SLSQP. COBYLA never looks at its limits while it solves the linear
/// program of a step, and that may go round in circles (NLopt's issues 118 and 370): it did in 1 of 100 solves down to
/// steps of 1e-6 with balls as they are, whose tip has no linear model, and in none of 4000 down to 1e-3 with balls as
/// rows.
nlopt_result cobyla(WatchedProgram& watched, const Eigen::VectorXd& start, const InnerOptions& options) {
  constexpr double kCoarse = 1e-2;  // [m], [rad]
  BallsAsRows intervals{watched};
  Eigen::VectorXd x;
  try {
    x = intervals.extended(start);
  } catch (const NotANumber&) {
    return NLOPT_FAILURE;
  }
  const Opt opt = make(NLOPT_LN_COBYLA, intervals.n_variables());
  nlopt_set_xtol_abs1(opt.get(), kCoarse);
  Problem problem{watched, intervals, Form::kRows};
  const nlopt_result rough =
      problem.run(opt, x, intervals.lower(), intervals.upper(), options.max_evaluations * 4 / 5, 1e-6);
  if (rough == NLOPT_FORCED_STOP) return rough;
  return slsqp(watched, intervals.reduced(x), options);
}

struct GlobalMethod {
  nlopt_algorithm algorithm;
  Form form;
  bool stochastic;
};

GlobalMethod global_method(Inner inner) {
  switch (inner) {
    case Inner::kDirect:
      return {NLOPT_GN_DIRECT_L, Form::kLinearPenalty, false};
    case Inner::kCrs2:
      return {NLOPT_GN_CRS2_LM, Form::kLinearPenalty, true};
    case Inner::kIsres:
      return {NLOPT_GN_ISRES, Form::kRows, true};
    case Inner::kMlsl:
      return {NLOPT_G_MLSL_LDS, Form::kQuadraticPenalty, true};
    case Inner::kSlsqp:
    case Inner::kCobyla:
    case Inner::kOwn:
    case Inner::kIpopt:
    case Inner::kCeres:
      break;
  }
  throw std::invalid_argument("minimise: not a global method of NLopt");
}

/// Global methods divide a box, and an endless joint has none: two turns about 0 hold every posture.
void make_finite(Eigen::VectorXd& lower, Eigen::VectorXd& upper) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  for (Eigen::Index i = 0; i < lower.size(); ++i) {
    if (std::isinf(upper[i])) upper[i] = std::isinf(lower[i]) ? kTurn : std::max(kTurn, lower[i] + kTurn);
    if (std::isinf(lower[i])) lower[i] = std::min(-kTurn, upper[i] - kTurn);
  }
}

/// A global method with four fifths of the evaluations, then SLSQP from where it ended.
nlopt_result global_then_slsqp(Inner inner, WatchedProgram& watched, const Eigen::VectorXd& start,
                               const InnerOptions& options) {
  const GlobalMethod method = global_method(inner);
  Eigen::VectorXd lower = watched.lower(), upper = watched.upper(), x = start;
  make_finite(lower, upper);
  const Opt opt = make(method.algorithm, watched.n_variables());
  nlopt_set_xtol_rel(opt.get(), 1e-6);  // SLSQP does the rest
  if (inner == Inner::kMlsl) {
    const Opt local = make(NLOPT_LD_SLSQP, watched.n_variables());
    nlopt_set_xtol_rel(local.get(), 1e-6);
    nlopt_set_maxeval(local.get(), 200);
    nlopt_set_local_optimizer(opt.get(), local.get());
  }
  // The generator is one for the whole process: nobody else may draw from it between the seed and the end.
  static std::mutex generator;
  std::unique_lock<std::mutex> lock;
  if (method.stochastic) {
    lock = std::unique_lock{generator};
    nlopt_srand(static_cast<unsigned long>(options.seed));
  }
  Problem problem{watched, watched, method.form};
  const nlopt_result rough = problem.run(opt, x, lower, upper, options.max_evaluations * 4 / 5, 1e-6);
  if (lock.owns_lock()) lock.unlock();
  if (rough == NLOPT_FORCED_STOP) return rough;
  return slsqp(watched, x, options);
}

nlopt_result run(Inner inner, WatchedProgram& watched, const Eigen::VectorXd& start, const InnerOptions& options) {
  if (inner == Inner::kSlsqp) return slsqp(watched, start, options);
  if (inner == Inner::kCobyla) return cobyla(watched, start, options);
  return global_then_slsqp(inner, watched, start, options);
}

}  // namespace

InnerResult minimise_nlopt(Inner inner, SmoothProgram& program, const Eigen::VectorXd& start,
                           const InnerOptions& options, Meter& meter) {
  WatchedProgram watched{program, options, meter};
  return watched.result(status_of(run(inner, watched, start, options)));
}

}  // namespace modsearch
