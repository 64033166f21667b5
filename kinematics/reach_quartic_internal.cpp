#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <modsearch/kinematics/reach_quartic_internal.hpp>

namespace modsearch::internal {
namespace {

using Complex = std::complex<double>;

// A quantity that is linear in cosine and sine of q_2: constant + c cos + s sin.
template <typename T>
struct Harmonic {
  T constant, c, s;
  [[nodiscard]] T at(double cosine, double sine) const { return constant + cosine * c + sine * s; }
};

// |v|^2 of a harmonic vector: a0 + a1 cos q + b1 sin q + a2 cos 2q + b2 sin 2q.
Eigen::Matrix<double, 5, 1> squared(const Harmonic<Eigen::Vector2d>& v) {
  Eigen::Matrix<double, 5, 1> result;
  result << v.constant.squaredNorm() + 0.5 * (v.c.squaredNorm() + v.s.squaredNorm()), 2.0 * v.constant.dot(v.c),
      2.0 * v.constant.dot(v.s), 0.5 * (v.c.squaredNorm() - v.s.squaredNorm()), v.c.dot(v.s);
  return result;
}

// Roots of the polynomial with `degree` + 1 coefficients, constant first, by the Ehrlich-Aberth iteration.
int roots_of(const std::array<Complex, 5>& polynomial, int degree, std::array<Complex, 4>& roots) {
  constexpr int kIterations = 40;
  for (int i = 0; i < degree; ++i)
    roots[static_cast<std::size_t>(i)] = std::polar(i % 2 == 0 ? 0.9 : 1.1, 0.4 + 1.6 * i);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    double moved = 0.0;
    for (int i = 0; i < degree; ++i) {
      Complex& z = roots[static_cast<std::size_t>(i)];
      Complex value = polynomial[static_cast<std::size_t>(degree)];
      Complex slope = 0.0;
      for (int k = degree - 1; k >= 0; --k) {
        slope = slope * z + value;
        value = value * z + polynomial[static_cast<std::size_t>(k)];
      }
      if (value == 0.0) continue;
      Complex repulsion = 0.0;
      for (int j = 0; j < degree; ++j) {
        if (j != i && z != roots[static_cast<std::size_t>(j)])
          repulsion += 1.0 / (z - roots[static_cast<std::size_t>(j)]);
      }
      const Complex step = value / (slope - value * repulsion);
      if (!std::isfinite(step.real()) || !std::isfinite(step.imag())) continue;
      z -= step;
      moved = std::max(moved, std::abs(step) / (1e-3 + std::abs(z)));
    }
    if (moved < 1e-10) break;
  }
  return degree;
}

// Arguments on the unit circle of the roots of f = a0 + a1 cos + b1 sin + a2 cos 2 + b2 sin 2, with z = e^(i q):
// 2 f z^2 = C2 z^4 + C1 z^3 + 2 a0 z^2 + conj(C1) z + conj(C2). Roots off the circle come in pairs of one argument.
int angles_of_roots(const Eigen::Matrix<double, 5, 1>& f, std::array<double, 4>& angles) {
  constexpr double kNegligible = 1e-13;
  const Complex C1{f[1], -f[2]};
  const Complex C2{f[3], -f[4]};
  const double largest = f.cwiseAbs().maxCoeff();
  std::array<Complex, 4> roots;
  int count = 0;
  if (std::abs(C2) > kNegligible * largest) {
    count = roots_of({std::conj(C2), std::conj(C1), 2.0 * f[0], C1, C2}, 4, roots);
  } else if (std::abs(C1) > kNegligible * largest) {
    count = roots_of({std::conj(C1), 2.0 * f[0], C1, 0.0, 0.0}, 2, roots);
  }
  int distinct = 0;
  for (int i = 0; i < count; ++i) {
    const double angle = std::arg(roots[static_cast<std::size_t>(i)]);
    if (std::none_of(angles.begin(), angles.begin() + distinct,
                     [&](double other) { return std::abs(angle - other) < 1e-9; })) {
      angles[static_cast<std::size_t>(distinct++)] = angle;
    }
  }
  return distinct;
}

}  // namespace

NearestList reaching_postures(const ReachProblem& problem) {
  NearestList result;
  const ReachLink& base = problem.links[0];
  const ReachLink& one = problem.links[1];
  const ReachLink& two = problem.links[2];
  if (problem.n != 3 || !one.rotates || !two.rotates) return result;

  // The tip in the frame that moves with joint 1: w(q_2).
  const Harmonic<Eigen::Vector3d> w{one.p + one.R.col(2) * two.p.z(),
                                    one.R.col(0) * two.p.x() + one.R.col(1) * two.p.y(),
                                    one.R.col(1) * two.p.x() - one.R.col(0) * two.p.y()};
  const Harmonic<Eigen::Vector2d> level{w.constant.head<2>(), w.c.head<2>(), w.s.head<2>()};

  // Two equations without q_0, linear in u = Rz(q_1) w (its x and y): M u = beta(q_2). A turning joint 0 leaves height
  // and distance from its origin alone, a sliding one the two other coordinates.
  const Eigen::Vector3d& o = base.p;
  const Eigen::Vector3d& t = problem.target;
  Eigen::Matrix2d M;
  Harmonic<Eigen::Vector2d> beta;
  if (base.rotates) {
    const Eigen::Vector3d h = base.R.transpose() * o;
    M << h.x(), h.y(), base.R(2, 0), base.R(2, 1);
    const double squares = w.constant.squaredNorm() + 0.5 * (w.c.squaredNorm() + w.s.squaredNorm());  // |w.c| = |w.s|
    beta.constant = {0.5 * (t.squaredNorm() - o.squaredNorm() - squares) - h.z() * w.constant.z(),
                     t.z() - o.z() - base.R(2, 2) * w.constant.z()};
    beta.c = {-w.constant.dot(w.c) - h.z() * w.c.z(), -base.R(2, 2) * w.c.z()};
    beta.s = {-w.constant.dot(w.s) - h.z() * w.s.z(), -base.R(2, 2) * w.s.z()};
  } else {
    M = base.R.topLeftCorner<2, 2>();
    const Eigen::Vector2d up = base.R.block<2, 1>(0, 2);
    beta = {t.head<2>() - o.head<2>() - up * w.constant.z(), -up * w.c.z(), -up * w.s.z()};
  }

  if (base.rotates) {
    // Both rows without a unit.
    const double scale = 1.0 / (o.norm() + w.constant.norm() + w.c.norm() + std::numeric_limits<double>::min());
    M.row(0) *= scale;
    beta.constant[0] *= scale;
    beta.c[0] *= scale;
    beta.s[0] *= scale;
  }

  const auto add = [&](double q2, const Eigen::Vector2d& u) {
    const Eigen::Vector2d v = level.at(std::cos(q2), std::sin(q2));
    const double q1 = std::atan2(u.y() * v.x() - u.x() * v.y(), u.x() * v.x() + u.y() * v.y());
    result.add({{0.0, q1, q2}, 0.0});
  };
  std::array<double, 4> q2;
  constexpr double kParallel = 1e-7;
  if (std::abs(M.determinant()) > kParallel * M.cwiseAbs().maxCoeff() * M.cwiseAbs().maxCoeff()) {
    // |u|^2 = |w|^2 (x and y): the quartic.
    const Eigen::Matrix2d inverse = M.inverse();
    const Harmonic<Eigen::Vector2d> u{inverse * beta.constant, inverse * beta.c, inverse * beta.s};
    const int count = angles_of_roots(squared(u) - squared(level), q2);
    for (int i = 0; i < count; ++i) {
      const double angle = q2[static_cast<std::size_t>(i)];
      add(angle, u.at(std::cos(angle), std::sin(angle)));
    }
    return result;
  }
  // The rows are parallel, or one is zero: a combination of the equations is free of u and gives q_2, the row with
  // something in it gives q_1.
  const int row = M.row(0).squaredNorm() > M.row(1).squaredNorm() ? 0 : 1;
  const Eigen::Vector2d n = M.row(row);
  if (n.norm() < kParallel) return result;
  const double ratio = M.row(1 - row).dot(n) / n.squaredNorm();
  const auto without_u = [&](const Eigen::Vector2d& b) { return b[1 - row] - ratio * b[row]; };
  Eigen::Matrix<double, 5, 1> f;
  f << without_u(beta.constant), without_u(beta.c), without_u(beta.s), 0.0, 0.0;
  const int count = angles_of_roots(f, q2);
  for (int i = 0; i < count; ++i) {
    const double angle = q2[static_cast<std::size_t>(i)];
    const double radius = level.at(std::cos(angle), std::sin(angle)).norm();
    const double along = beta.at(std::cos(angle), std::sin(angle))[row] / n.norm();
    const double across = std::sqrt(std::max(0.0, radius * radius - along * along));
    const Eigen::Vector2d unit = n.normalized();
    const Eigen::Vector2d normal{-unit.y(), unit.x()};
    add(angle, along * unit + across * normal);
    add(angle, along * unit - across * normal);
  }
  return result;
}

}  // namespace modsearch::internal
