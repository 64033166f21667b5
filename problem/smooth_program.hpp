#pragma once

#include <Eigen/Core>
#include <modsearch/problem/design.hpp>
#include <vector>

namespace modsearch {

/// Rows first .. first + count - 1 form a vector that has to stay within a ball of `radius` about 0: the tolerance of a
/// goal. Solvers that know only intervals see it through `BallsAsRows`.
struct BallRows {
  int first = 0;
  int count = 0;
  double radius = 0.0;
};

/// min f(v) over lower <= v <= upper, row_lower <= c(v) <= row_upper, and vectors of rows within balls: the smooth
/// relaxation of a fixed type sequence. Variables are (x, q_goal1, q_goal2, ..): lengths in metres, angles in radians.
///
/// A program is also a workspace: one thread at a time.
class SmoothProgram {
 public:
  /// Value and first derivatives at a point. Kept by the caller and reused, so that nothing is allocated in a loop.
  struct Values {
    double objective = 0.0;    ///< f
    Eigen::VectorXd gradient;  ///< df/dv [n]
    Eigen::VectorXd rows;      ///< c [m]
    Eigen::MatrixXd jacobian;  ///< dc/dv [m x n]
  };

  virtual ~SmoothProgram() = default;

  [[nodiscard]] int n_variables() const { return static_cast<int>(lower_.size()); }
  [[nodiscard]] int n_rows() const { return static_cast<int>(row_lower_.size()); }
  [[nodiscard]] const Eigen::VectorXd& lower() const { return lower_; }
  [[nodiscard]] const Eigen::VectorXd& upper() const { return upper_; }
  /// Intervals of the rows; (-inf, +inf) for rows that belong to a ball.
  [[nodiscard]] const Eigen::VectorXd& row_lower() const { return row_lower_; }
  [[nodiscard]] const Eigen::VectorXd& row_upper() const { return row_upper_; }
  [[nodiscard]] const std::vector<BallRows>& balls() const { return balls_; }

  /// f, c and their exact first derivatives at `v` [n].
  /// Throws std::invalid_argument if v.size() != n_variables() or an entry is not finite.
  void evaluate(const Eigen::VectorXd& v, Values& values);
  /// objective_factor * d2f/dv2 + sum_i multipliers_i * d2c_i/dv2 [n x n], symmetric. Exact for mass and positions;
  /// clearance rows count as linear. Throws like evaluate.
  [[nodiscard]] Eigen::MatrixXd hessian(const Eigen::VectorXd& v, double objective_factor,
                                        const Eigen::VectorXd& multipliers);

  /// A program may leave out rows that hold with room to spare, such as those of bodies that are far apart. Adds,
  /// behind the rows there are, those left out that do not hold at `v` [n] or hold by less than the program's margin;
  /// returns how many. Where it returns 0, every row left out holds: only then do `violation` and multipliers speak of
  /// the whole program. A program that leaves nothing out returns 0. Throws like evaluate.
  int grow(const Eigen::VectorXd& v);
  /// Leaves out again whatever `grow` added: a solve begins with it, so that equal inputs give equal answers.
  void shrink() { do_shrink(); }

  /// Largest violation of bounds, rows and balls, in the rows' own units, at rows `c` [m] of point `v` [n]; 0 where all
  /// hold, +inf where a number is NaN. Throws std::invalid_argument for other sizes.
  [[nodiscard]] double violation(const Eigen::VectorXd& v, const Eigen::VectorXd& c) const;

  /// Start number `index` (0, 1, ..) of a fixed low-discrepancy sequence, spread over the bounds; one turn about 0
  /// stands for the bounds of an endless joint. Throws std::invalid_argument if index < 0.
  [[nodiscard]] virtual Eigen::VectorXd start(int index);
  /// The design at `v`, its parameters clamped into their intervals.
  [[nodiscard]] virtual Design design(const Eigen::VectorXd& v) const = 0;

 protected:
  Eigen::VectorXd lower_, upper_;          // [n]
  Eigen::VectorXd row_lower_, row_upper_;  // [m]
  std::vector<BallRows> balls_;

 private:
  virtual void do_evaluate(const Eigen::VectorXd& v, Values& values) = 0;
  [[nodiscard]] virtual Eigen::MatrixXd do_hessian(const Eigen::VectorXd& v, double objective_factor,
                                                   const Eigen::VectorXd& multipliers) = 0;
  [[nodiscard]] virtual int do_grow(const Eigen::VectorXd& /*v*/) { return 0; }
  virtual void do_shrink() {}
};

/// The same program with intervals only: each ball of radius R gets a variable u in [-1, 1]^count, rows c - R u = 0 and
/// a row |u|^2 <= 1. Better conditioned than |c|^2 <= R^2: the pose rows stay nearly linear, whatever the tolerance.
/// Where it can be simpler it is: a ball of radius 0 is rows c = 0 without u, and a single row needs no |u|^2 <= 1.
/// Variables are (inner variables, u of the first ball, ..), rows (inner rows, |u|^2 of the first ball, ..): those that
/// the inner program has when this one is made.
class BallsAsRows final : public SmoothProgram {
 public:
  /// `inner` must outlive it.
  explicit BallsAsRows(SmoothProgram& inner);
  [[nodiscard]] Eigen::VectorXd start(int index) override;
  [[nodiscard]] Design design(const Eigen::VectorXd& v) const override;
  /// A point of the inner program with u filled in as well as it can be: c / R, scaled back into the ball. Evaluates
  /// the inner program once.
  [[nodiscard]] Eigen::VectorXd extended(const Eigen::VectorXd& inner_point);
  /// The inner program's part of `v`.
  [[nodiscard]] Eigen::VectorXd reduced(const Eigen::VectorXd& v) const;

 private:
  void do_evaluate(const Eigen::VectorXd& v, Values& values) override;
  [[nodiscard]] Eigen::MatrixXd do_hessian(const Eigen::VectorXd& v, double objective_factor,
                                           const Eigen::VectorXd& multipliers) override;
  SmoothProgram& inner_;
  Values inner_values_;
};

}  // namespace modsearch
