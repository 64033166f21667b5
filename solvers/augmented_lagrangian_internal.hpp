#pragma once

#include <modsearch/solvers/watched_program_internal.hpp>
#include <vector>

namespace modsearch {

/// What the augmented Lagrangian is made of at one point. Where the program has grown since, the point has fewer rows:
/// those it lacks hold there, and their multipliers are 0.
struct AugmentedPoint {
  Eigen::VectorXd v;
  SmoothProgram::Values values;
  Eigen::VectorXd excess;    ///< y - P(y), see AugmentedLagrangian
  Eigen::VectorXd gradient;  ///< of phi [n]
  double phi = 0.0;          ///< the augmented Lagrangian, less a constant
  double violation = 0.0;    ///< of the rows
};

/// min f(v) with rows c(v) in a set S of intervals and balls, and v within bounds, turned into
///
///   phi(v) = f + rho / 2 |y - P(y)|^2,   y = c(v) + lambda / rho,   P the projection onto S,
///
/// to be minimised within the bounds for lambda <- rho (y - P(y)), again and again (Hestenes 1969 and Powell 1969;
/// Rockafellar 1973 for sets). A ball is projected onto as it is, and nothing is singular at its centre.
///
/// A row that holds and has no multiplier has no part in phi. So the program grows at every point that is looked at,
/// and phi is that of all rows: its value, its derivatives and the way the search takes are those without leaving out.
class AugmentedLagrangian {
 public:
  /// All three must outlive it.
  AugmentedLagrangian(SmoothProgram& program, const InnerOptions& options, Meter& meter, double rho);

  [[nodiscard]] const SmoothProgram& program() const { return program_; }
  [[nodiscard]] const InnerOptions& options() const { return options_; }
  [[nodiscard]] double rho() const { return rho_; }
  [[nodiscard]] bool stopped() const { return meter_.stopped().has_value(); }

  /// Fills in `point` from point.v, counting the evaluation and remembering the best. False: not a number.
  [[nodiscard]] bool evaluate(AugmentedPoint& point);
  /// Second derivative of phi at `point`, lower triangle: that of the Lagrangian with lambda = rho (y - P(y)), plus
  /// rho J^T (I - dP/dy) J.
  void hessian(const AugmentedPoint& point, Eigen::MatrixXd& H);

  /// The variable is at a bound against which -g pushes it.
  [[nodiscard]] bool held(const AugmentedPoint& point, const Eigen::VectorXd& g, Eigen::Index i) const {
    return (point.v[i] <= program_.lower()[i] && g[i] >= 0.0) || (point.v[i] >= program_.upper()[i] && g[i] <= 0.0);
  }
  /// Largest entry of the gradient that is not held.
  [[nodiscard]] double projected_gradient(const AugmentedPoint& point) const { return largest(point, point.gradient); }
  /// Up to here the projected gradient counts as zero.
  [[nodiscard]] double gradient_tolerance() const;
  /// Largest change of lambda / rho that `update` would make. At a solution it is 0; it bounds the violation, and how
  /// far the point is from where the multipliers push.
  [[nodiscard]] double shift(const AugmentedPoint& point) const;
  /// The distance of c from S is not zero and, to first order, cannot be made smaller within the bounds.
  [[nodiscard]] bool nearest_to_feasible(const AugmentedPoint& point) const;
  /// lambda <- rho (y - P(y)), then a new penalty; `point` is adapted.
  void update(AugmentedPoint& point, double rho);

  [[nodiscard]] InnerResult result(InnerStatus status) const {
    return make_result(status, best_, evaluations_, options_, meter_);
  }

 private:
  void augment(AugmentedPoint& point) const;
  void fit_rows();
  [[nodiscard]] double largest(const AugmentedPoint& point, const Eigen::VectorXd& g) const;

  SmoothProgram& program_;
  const InnerOptions& options_;
  Meter& meter_;
  Eigen::Index n_;
  std::vector<bool> in_ball_;
  Eigen::VectorXd lambda_;  // [n_rows of the program]
  double rho_;
  std::int64_t evaluations_ = 0;
  BestPoint best_;
  // Storage of hessian().
  Eigen::VectorXd multipliers_;
  Eigen::MatrixXd weighted_;             // rho (I - dP/dy) J of a ball
  std::vector<Eigen::Index> variables_;  // that a ball or a row depends on
};

/// Minimises phi within the bounds, for the method of multipliers.
class Descent {
 public:
  enum class End {
    kReached,     ///< the projected gradient is at most omega
    kRounding,    ///< phi cannot be seen to fall any further: as minimal as floating point can tell
    kNoProgress,  ///< no step was found that decreases phi
    kLimit,       ///< iterations are spent
    kStopped,     ///< the meter said stop
  };
  struct Outcome {
    End end;
    int steps;
  };
  virtual ~Descent() = default;
  /// From `here` until the projected gradient is at most `omega`; `here` becomes the point it ended at.
  [[nodiscard]] virtual Outcome descend(AugmentedLagrangian& phi, AugmentedPoint& here, double omega) = 0;
};

/// The method of multipliers from `start` (within the bounds).
[[nodiscard]] InnerResult method_of_multipliers(SmoothProgram& program, const Eigen::VectorXd& start,
                                                const InnerOptions& options, Meter& meter, Descent& descent);

}  // namespace modsearch
