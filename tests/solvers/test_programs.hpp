#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <modsearch/problem/smooth_program.hpp>
#include <numbers>
#include <random>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

// Smooth programs whose optimum is known in closed form or from the literature, and programs that misbehave.
namespace modsearch::test {

inline constexpr double kInf = std::numeric_limits<double>::infinity();

/// A program made of functions; the design is always empty.
class TestProgram : public SmoothProgram {
 public:
  [[nodiscard]] Design design(const Eigen::VectorXd&) const override { return {}; }
};

/// Hock and Schittkowski (1981), problem 71: min x1 x4 (x1 + x2 + x3) + x3, x1 x2 x3 x4 >= 25, |x|^2 = 40, 1 <= x <= 5.
/// From (1, 5, 5, 1) to f = 17.0140173 at (1, 4.7429994, 3.8211503, 1.3794082).
class HockSchittkowski71 final : public TestProgram {
 public:
  HockSchittkowski71() {
    lower_ = Eigen::Vector4d::Constant(1.0);
    upper_ = Eigen::Vector4d::Constant(5.0);
    row_lower_ = Eigen::Vector2d{25.0, 40.0};
    row_upper_ = Eigen::Vector2d{kInf, 40.0};
  }
  static constexpr double kOptimum = 17.0140173;
  [[nodiscard]] static Eigen::VectorXd usual_start() { return Eigen::Vector4d{1.0, 5.0, 5.0, 1.0}; }

 private:
  void do_evaluate(const Eigen::VectorXd& x, Values& values) override {
    values.objective = x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2];
    values.gradient =
        Eigen::Vector4d{x[3] * (2.0 * x[0] + x[1] + x[2]), x[0] * x[3], x[0] * x[3] + 1.0, x[0] * (x[0] + x[1] + x[2])};
    values.rows = Eigen::Vector2d{x[0] * x[1] * x[2] * x[3], x.squaredNorm()};
    values.jacobian.resize(2, 4);
    values.jacobian << x[1] * x[2] * x[3], x[0] * x[2] * x[3], x[0] * x[1] * x[3], x[0] * x[1] * x[2],  //
        2.0 * x[0], 2.0 * x[1], 2.0 * x[2], 2.0 * x[3];
  }
  [[nodiscard]] Eigen::MatrixXd do_hessian(const Eigen::VectorXd& x, double factor, const Eigen::VectorXd& y) override {
    Eigen::Matrix4d f, product;
    f << 2.0 * x[3], x[3], x[3], 2.0 * x[0] + x[1] + x[2],  //
        x[3], 0.0, 0.0, x[0],                               //
        x[3], 0.0, 0.0, x[0],                               //
        2.0 * x[0] + x[1] + x[2], x[0], x[0], 0.0;
    product << 0.0, x[2] * x[3], x[1] * x[3], x[1] * x[2],  //
        x[2] * x[3], 0.0, x[0] * x[3], x[0] * x[2],         //
        x[1] * x[3], x[0] * x[3], 0.0, x[0] * x[1],         //
        x[1] * x[2], x[0] * x[2], x[0] * x[1], 0.0;
    return factor * f + y[0] * product + 2.0 * y[1] * Eigen::Matrix4d::Identity();
  }
};

/// min (1 - x)^2 + 100 (y - x^2)^2, (x, y) within `radius` of the origin. The minimiser of Rosenbrock's function, (1,
/// 1), is inside for radius > sqrt 2; for radius 1 the optimum is 0.045674808 at (0.786415, 0.617698) (the known value
/// of this textbook example: a line search along the circle gives it too).
class RosenbrockInBall final : public TestProgram {
 public:
  explicit RosenbrockInBall(double radius) {
    lower_ = Eigen::Vector2d::Constant(-1.5);
    upper_ = Eigen::Vector2d::Constant(1.5);
    row_lower_ = Eigen::Vector2d::Constant(-kInf);
    row_upper_ = Eigen::Vector2d::Constant(kInf);
    balls_ = {{.first = 0, .count = 2, .radius = radius}};
  }

 private:
  void do_evaluate(const Eigen::VectorXd& v, Values& values) override {
    const double x = v[0], y = v[1], valley = y - x * x;
    values.objective = (1.0 - x) * (1.0 - x) + 100.0 * valley * valley;
    values.gradient = Eigen::Vector2d{-2.0 * (1.0 - x) - 400.0 * x * valley, 200.0 * valley};
    values.rows = v;
    values.jacobian = Eigen::Matrix2d::Identity();
  }
  [[nodiscard]] Eigen::MatrixXd do_hessian(const Eigen::VectorXd& v, double factor, const Eigen::VectorXd&) override {
    const double x = v[0], y = v[1];
    Eigen::Matrix2d h;
    h << 2.0 - 400.0 * (y - 3.0 * x * x), -400.0 * x, -400.0 * x, 200.0;
    return factor * h;
  }
};

/// min x + y with x + y >= 3 in the unit square: nothing is feasible; the least violation is 1, at (1, 1).
class Infeasible final : public TestProgram {
 public:
  Infeasible() {
    lower_ = Eigen::Vector2d::Zero();
    upper_ = Eigen::Vector2d::Ones();
    row_lower_ = Eigen::VectorXd::Constant(1, 3.0);
    row_upper_ = Eigen::VectorXd::Constant(1, kInf);
  }

 private:
  void do_evaluate(const Eigen::VectorXd& v, Values& values) override {
    values.objective = v.sum();
    values.gradient = Eigen::Vector2d::Ones();
    values.rows = Eigen::VectorXd::Constant(1, v.sum());
    values.jacobian = Eigen::MatrixXd::Ones(1, 2);
  }
  [[nodiscard]] Eigen::MatrixXd do_hessian(const Eigen::VectorXd&, double, const Eigen::VectorXd&) override {
    return Eigen::MatrixXd::Zero(2, 2);
  }
};

/// An arm of m segments: joint i turns about x, y or z of its frame, then the frame moves by length_i along its z.
/// Variables (lengths [m], angles [rad]); objective the sum of the lengths; the tip within `radius` of a target.
/// Derivatives by the geometric formulas: dp/dq_i = a_i x (p - o_i), d2p/dq_i dq_j = a_i x (a_j x (p - o_j)) for i <=
/// j, dp/dl_k = d_k, d2p/dq_i dl_k = a_i x d_k for i <= k; positions are affine in the lengths.
class ArmProgram final : public TestProgram {
 public:
  struct Spec {
    std::string axes = "zy";  ///< one letter per joint
    double shortest = 0.5;    ///< bounds of every length [m]
    double longest = 1.5;
    double turn = std::numbers::pi;  ///< joint limits -turn .. turn [rad]
    Eigen::Vector3d target{1.0, 0.0, 1.0};
    double radius = 1e-3;
  };

  explicit ArmProgram(const Spec& spec) : spec_{spec}, m_{static_cast<Eigen::Index>(spec.axes.size())} {
    lower_.resize(2 * m_);
    upper_.resize(2 * m_);
    lower_ << Eigen::VectorXd::Constant(m_, spec.shortest), Eigen::VectorXd::Constant(m_, -spec.turn);
    upper_ << Eigen::VectorXd::Constant(m_, spec.longest), Eigen::VectorXd::Constant(m_, spec.turn);
    row_lower_ = Eigen::Vector3d::Constant(-kInf);
    row_upper_ = Eigen::Vector3d::Constant(kInf);
    balls_ = {{.first = 0, .count = 3, .radius = spec.radius}};
    axis_.resize(3, m_);
    origin_.resize(3, m_);
    direction_.resize(3, m_);
    lever_.resize(3, m_);
  }

  [[nodiscard]] const Spec& spec() const { return spec_; }
  /// Where the tip is at `v`.
  [[nodiscard]] Eigen::Vector3d tip(const Eigen::VectorXd& v) {
    forward(v);
    return tip_;
  }

 private:
  void forward(const Eigen::VectorXd& v) {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    tip_.setZero();
    for (Eigen::Index i = 0; i < m_; ++i) {
      const int a = spec_.axes[static_cast<std::size_t>(i)] - 'x';
      origin_.col(i) = tip_;
      axis_.col(i) = R.col(a);
      const double c = std::cos(v[m_ + i]), s = std::sin(v[m_ + i]);
      const Eigen::Vector3d e1 = R.col((a + 1) % 3), e2 = R.col((a + 2) % 3);
      R.col((a + 1) % 3) = c * e1 + s * e2;
      R.col((a + 2) % 3) = c * e2 - s * e1;
      direction_.col(i) = R.col(2);
      tip_ += v[i] * R.col(2);
    }
    for (Eigen::Index i = 0; i < m_; ++i) lever_.col(i) = axis_.col(i).cross(tip_ - origin_.col(i));
  }

  void do_evaluate(const Eigen::VectorXd& v, Values& values) override {
    forward(v);
    values.objective = v.head(m_).sum();
    values.gradient.resize(2 * m_);
    values.gradient.head(m_).setOnes();
    values.gradient.tail(m_).setZero();
    values.rows = tip_ - spec_.target;
    values.jacobian.resize(3, 2 * m_);
    values.jacobian.leftCols(m_) = direction_;
    values.jacobian.rightCols(m_) = lever_;
  }

  [[nodiscard]] Eigen::MatrixXd do_hessian(const Eigen::VectorXd& v, double, const Eigen::VectorXd& y3) override {
    forward(v);
    const Eigen::Vector3d y = y3;
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(2 * m_, 2 * m_);
    for (Eigen::Index i = 0; i < m_; ++i) {
      const Eigen::Vector3d ya = y.cross(axis_.col(i));  // y . (a x b) = (y x a) . b
      for (Eigen::Index k = i; k < m_; ++k) {
        h(m_ + i, m_ + k) = h(m_ + k, m_ + i) = ya.dot(lever_.col(k));
        h(m_ + i, k) = h(k, m_ + i) = ya.dot(direction_.col(k));
      }
    }
    return h;
  }

  Spec spec_;
  Eigen::Index m_;
  Eigen::Matrix3Xd axis_, origin_, direction_, lever_;
  Eigen::Vector3d tip_;
};

/// One hinge on a yawing base, lengths p (upright) and d (tilted): reaches a target at distance rho from the z axis and
/// height z iff |hypot(rho, z - p) - d| <= radius. p + d falls by 1 - (z - p) / hypot(..) > 0 per metre that p is
/// shortened, so p is as short as allowed, 0.5 m, and d ends a tolerance short of the target: at (1, 0, 1),
/// p + d = 0.5 + sqrt(1.25) - 0.001.
struct OneHinge {
  static ArmProgram program() { return ArmProgram{{.axes = "zy"}}; }
  static double optimum() { return 0.5 + std::sqrt(1.25) - 0.001; }
};

/// An arm of `joints` joints with a target that a random posture of it reaches.
inline ArmProgram random_arm(int joints, unsigned seed, double shortest = 0.5, double longest = 1.5) {
  std::mt19937 generator{seed};
  std::uniform_real_distribution<double> uniform{0.0, 1.0};
  ArmProgram::Spec spec{.axes = "z", .shortest = shortest, .longest = longest};
  while (static_cast<int>(spec.axes.size()) < joints) spec.axes += uniform(generator) < 0.5 ? 'x' : 'y';
  ArmProgram arm{spec};
  Eigen::VectorXd v(arm.n_variables());
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    v[i] = arm.lower()[i] + uniform(generator) * (arm.upper()[i] - arm.lower()[i]);
  }
  spec.target = arm.tip(v);
  return ArmProgram{spec};
}

/// min -x - y over 0 <= x, y <= 2 with x + 2 y <= 2 and 2 x + y <= 2: f = -4/3 at (2/3, 2/3). Either row is left out
/// until it holds by less than 0.1, if at all. `before`: called before each evaluation with its number.
class LeavesOutRows final : public TestProgram {
 public:
  explicit LeavesOutRows(std::function<void(int call)> before = {}) : before_{std::move(before)} {
    lower_ = Eigen::Vector2d::Zero();
    upper_ = Eigen::Vector2d::Constant(2.0);
  }
  static constexpr double kOptimum = -4.0 / 3.0;

 private:
  static constexpr double kMargin = 0.1;
  [[nodiscard]] static Eigen::Matrix2d slopes() { return (Eigen::Matrix2d{} << 1.0, 2.0, 2.0, 1.0).finished(); }

  [[nodiscard]] int do_grow(const Eigen::VectorXd& v) override {
    int added = 0;
    for (int row = 0; row < 2; ++row) {
      if (std::find(rows_.begin(), rows_.end(), row) != rows_.end() || slopes().row(row).dot(v) < 2.0 - kMargin)
        continue;
      rows_.push_back(row);
      ++added;
    }
    fit();
    return added;
  }
  void do_shrink() override {
    rows_.clear();
    fit();
  }
  void fit() {
    row_lower_.setConstant(static_cast<Eigen::Index>(rows_.size()), -kInf);
    row_upper_.setConstant(static_cast<Eigen::Index>(rows_.size()), 2.0);
  }
  void do_evaluate(const Eigen::VectorXd& v, Values& values) override {
    if (before_) before_(++calls_);
    values.objective = -v.sum();
    values.gradient = -Eigen::Vector2d::Ones();
    values.rows.resize(n_rows());
    values.jacobian.resize(n_rows(), 2);
    for (Eigen::Index i = 0; i < n_rows(); ++i) {
      values.jacobian.row(i) = slopes().row(rows_[static_cast<std::size_t>(i)]);
      values.rows[i] = values.jacobian.row(i).dot(v);
    }
  }
  [[nodiscard]] Eigen::MatrixXd do_hessian(const Eigen::VectorXd&, double, const Eigen::VectorXd&) override {
    return Eigen::Matrix2d::Zero();
  }
  std::function<void(int call)> before_;
  int calls_ = 0;
  std::vector<int> rows_;
};

/// Another program with something done before (`before`, given the number of the call) and after each evaluation.
class Wrapped final : public SmoothProgram {
 public:
  using Before = std::function<void(int call)>;
  using After = std::function<void(const Eigen::VectorXd& v, Values& values)>;

  Wrapped(SmoothProgram& inner, Before before, After after = {})
      : inner_{inner}, before_{std::move(before)}, after_{std::move(after)} {
    lower_ = inner.lower();
    upper_ = inner.upper();
    row_lower_ = inner.row_lower();
    row_upper_ = inner.row_upper();
    balls_ = inner.balls();
  }
  void set_bounds(Eigen::Index variable, double lower, double upper) {
    lower_[variable] = lower;
    upper_[variable] = upper;
  }
  [[nodiscard]] Design design(const Eigen::VectorXd& v) const override { return inner_.design(v); }
  [[nodiscard]] int calls() const { return calls_; }

 private:
  void do_evaluate(const Eigen::VectorXd& v, Values& values) override {
    ++calls_;
    if (before_) before_(calls_);
    inner_.evaluate(v, values);
    if (after_) after_(v, values);
  }
  [[nodiscard]] Eigen::MatrixXd do_hessian(const Eigen::VectorXd& v, double factor, const Eigen::VectorXd& y) override {
    return inner_.hessian(v, factor, y);
  }
  SmoothProgram& inner_;
  Before before_;
  After after_;
  int calls_ = 0;
};

/// Throws what no package knows, at the fifth evaluation only.
struct Sabotage : std::runtime_error {
  using std::runtime_error::runtime_error;
};
inline Wrapped throwing_at_call(SmoothProgram& inner, int number) {
  return Wrapped{inner, [number](int call) {
                   if (call == number) throw Sabotage{"call " + std::to_string(call)};
                 }};
}
/// NaN wherever v[index] > limit.
inline Wrapped nan_beyond(SmoothProgram& inner, Eigen::Index index, double limit) {
  return Wrapped{inner, {}, [=](const Eigen::VectorXd& v, SmoothProgram::Values& values) {
                   if (!(v[index] > limit)) return;
                   constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
                   values.objective = kNan;
                   values.gradient.setConstant(kNan);
                   values.rows.setConstant(kNan);
                   values.jacobian.setConstant(kNan);
                 }};
}
/// Asks to stop during evaluation `number`.
inline Wrapped stopping_at_call(SmoothProgram& inner, int number, std::stop_source source) {
  return Wrapped{inner, [number, source](int call) mutable {
                   if (call == number) source.request_stop();
                 }};
}

}  // namespace modsearch::test
