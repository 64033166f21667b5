#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>
#include <algorithm>
#include <modsearch/solvers/watched_program_internal.hpp>
#include <mutex>
#include <stdexcept>
#include <utility>

namespace modsearch {
namespace {

using Ipopt::Index;
using Ipopt::Number;

/// The program in Ipopt's terms, intervals only. Derivatives are dense. Ipopt asks for f, its gradient, c and its
/// Jacobian one at a time; the last point evaluated is kept so that all four cost one evaluation of the program.
///
/// Other exceptions than NotANumber pass through Ipopt, which is told to let them.
class Tnlp final : public Ipopt::TNLP {
 public:
  Tnlp(WatchedProgram& watched, BallsAsRows& program, Eigen::VectorXd start)
      : watched_{watched}, program_{program}, start_{std::move(start)} {}

  bool get_nlp_info(Index& n, Index& m, Index& nnz_jac, Index& nnz_hessian, IndexStyleEnum& style) override {
    n = program_.n_variables();
    m = program_.n_rows();
    nnz_jac = n * m;
    nnz_hessian = n * (n + 1) / 2;
    style = TNLP::C_STYLE;
    return true;
  }

  bool get_bounds_info(Index, Number* lower, Number* upper, Index, Number* row_lower, Number* row_upper) override {
    std::copy(program_.lower().begin(), program_.lower().end(), lower);
    std::copy(program_.upper().begin(), program_.upper().end(), upper);
    std::copy(program_.row_lower().begin(), program_.row_lower().end(), row_lower);
    std::copy(program_.row_upper().begin(), program_.row_upper().end(), row_upper);
    return true;
  }

  bool get_starting_point(Index, bool init_x, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    if (init_x) std::copy(start_.begin(), start_.end(), x);
    return true;
  }

  bool eval_f(Index, const Number* x, bool, Number& value) override {
    if (!move_to(x)) return false;
    value = values_.objective;
    return true;
  }

  bool eval_grad_f(Index, const Number* x, bool, Number* gradient) override {
    if (!move_to(x)) return false;
    std::copy(values_.gradient.begin(), values_.gradient.end(), gradient);
    return true;
  }

  bool eval_g(Index, const Number* x, bool, Index, Number* rows) override {
    if (!move_to(x)) return false;
    std::copy(values_.rows.begin(), values_.rows.end(), rows);
    return true;
  }

  bool eval_jac_g(Index n, const Number* x, bool, Index m, Index, Index* row, Index* column,
                  Number* jacobian) override {
    if (jacobian == nullptr) {
      for (Index j = 0; j < n; ++j) {
        for (Index i = 0; i < m; ++i) {
          *row++ = i;
          *column++ = j;
        }
      }
      return true;
    }
    if (!move_to(x)) return false;
    Eigen::Map<Eigen::MatrixXd>(jacobian, m, n) = values_.jacobian;
    return true;
  }

  bool eval_h(Index n, const Number* x, bool, Number factor, Index m, const Number* multipliers, bool, Index,
              Index* row, Index* column, Number* hessian) override {
    if (hessian == nullptr) {
      for (Index j = 0; j < n; ++j) {
        for (Index i = j; i < n; ++i) {
          *row++ = i;
          *column++ = j;
        }
      }
      return true;
    }
    try {
      const Eigen::MatrixXd H = program_.hessian(Eigen::Map<const Eigen::VectorXd>(x, n), factor,
                                                 Eigen::Map<const Eigen::VectorXd>(multipliers, m));
      for (Index j = 0; j < n; ++j) hessian = std::copy_n(H.data() + j * n + j, n - j, hessian);
      return true;
    } catch (const NotANumber&) {
      return false;
    }
  }

  bool intermediate_callback(Ipopt::AlgorithmMode, Index, Number, Number, Number, Number, Number, Number, Number,
                             Number, Index, const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    return !watched_.stopped();
  }

  // The watched program knows the best point already.
  void finalize_solution(Ipopt::SolverReturn, Index, const Number*, const Number*, const Number*, Index, const Number*,
                         const Number*, Number, const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {}

 private:
  // Evaluates at x unless that is where we are. False: the program is not a number there, and Ipopt shortens its step.
  bool move_to(const Number* x) {
    const Eigen::Map<const Eigen::VectorXd> point{x, program_.n_variables()};
    if (point_.size() == point.size() && point_ == point) return is_number_;
    point_ = point;
    try {
      is_number_ = false;
      program_.evaluate(point_, values_);
      is_number_ = true;
    } catch (const NotANumber&) {
    } catch (...) {
      point_.resize(0);
      throw;
    }
    return is_number_;
  }

  WatchedProgram& watched_;
  BallsAsRows& program_;
  Eigen::VectorXd start_;
  Eigen::VectorXd point_;
  SmoothProgram::Values values_;
  bool is_number_ = false;
};

InnerStatus status_of(Ipopt::ApplicationReturnStatus status) {
  switch (status) {
    case Ipopt::Solve_Succeeded:
    case Ipopt::Solved_To_Acceptable_Level:
    case Ipopt::Feasible_Point_Found:
    // No better step exists in floating point: as converged as it gets. The violation is checked anyway.
    case Ipopt::Search_Direction_Becomes_Too_Small:
      return InnerStatus::kConverged;
    case Ipopt::Infeasible_Problem_Detected:
      return InnerStatus::kInfeasible;
    case Ipopt::Maximum_Iterations_Exceeded:
    case Ipopt::Maximum_CpuTime_Exceeded:
      return InnerStatus::kLimit;
    case Ipopt::User_Requested_Stop:
      return InnerStatus::kStopped;
    case Ipopt::Insufficient_Memory:
      throw std::bad_alloc{};
    case Ipopt::Invalid_Option:
    case Ipopt::Internal_Error:
    case Ipopt::Diverging_Iterates:
    case Ipopt::Restoration_Failed:
    case Ipopt::Error_In_Step_Computation:
    case Ipopt::Not_Enough_Degrees_Of_Freedom:
    case Ipopt::Invalid_Problem_Definition:
    case Ipopt::Invalid_Number_Detected:
    case Ipopt::Unrecoverable_Exception:
    case Ipopt::NonIpopt_Exception_Thrown:
      return InnerStatus::kFailed;
  }
  return InnerStatus::kFailed;
}

Ipopt::SmartPtr<Ipopt::IpoptApplication> application(const InnerOptions& options) {
  Ipopt::SmartPtr<Ipopt::IpoptApplication> ipopt = new Ipopt::IpoptApplication(/*create_console_out=*/false);
  ipopt->RethrowNonIpoptException(true);
  const auto settings = ipopt->Options();
  settings->SetIntegerValue("print_level", 0);
  settings->SetStringValue("sb", "yes");             // no banner on stdout
  settings->SetStringValue("option_file_name", "");  // an ipopt.opt that happens to lie around changes nothing
  settings->SetIntegerValue("max_iter", options.max_iterations);
  settings->SetNumericValue("tol", options.tolerance);
  settings->SetNumericValue("constr_viol_tol",
                            0.1 * options.tolerance);    // rows c - R u, and u: leaves room for the ball
  settings->SetNumericValue("bound_relax_factor", 0.0);  // designs stay within their parameters' intervals
  settings->SetStringValue("honor_original_bounds", "yes");
  if (ipopt->Initialize("") != Ipopt::Solve_Succeeded) {
    throw std::runtime_error{"Ipopt refuses our options: is another version installed?"};
  }
  return ipopt;
}

}  // namespace

InnerResult minimise_ipopt(SmoothProgram& program, const Eigen::VectorXd& start, const InnerOptions& options,
                           Meter& meter) {
  // Debian's MUMPS keeps global state: two Ipopts at once in one process crash.
  static std::mutex one_at_a_time;
  const std::lock_guard lock{one_at_a_time};

  WatchedProgram watched{program, options, meter};
  BallsAsRows intervals{watched};
  Eigen::VectorXd extended;
  try {
    extended = intervals.extended(start);
  } catch (const NotANumber&) {
    return watched.result(InnerStatus::kFailed);
  }
  const Ipopt::SmartPtr<Ipopt::TNLP> tnlp = new Tnlp(watched, intervals, std::move(extended));
  return watched.result(status_of(application(options)->OptimizeTNLP(tnlp)));
}

}  // namespace modsearch
