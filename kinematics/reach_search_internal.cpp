#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/exact_reach_internal.hpp>
#include <modsearch/kinematics/reach_search_internal.hpp>
#include <numbers>

namespace modsearch::internal {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
// Points per joint; see docs/inverse_kinematics.md for what they were measured against.
constexpr int kPointsOfOne = 64;  // one joint besides joint 0
constexpr int kPointsOfTwo = 24;  // each of two joints besides joint 0

// Values of one joint on a regular grid, and the two numbers its motion is linear in: p(q) = P0 + a P1 + b P2.
template <int N>
struct Axis {
  Eigen::Array<double, N, 1> q, a, b;
  bool periodic;
};

template <int N>
Axis<N> make_axis(const ReachLink& link) {
  Axis<N> axis;
  axis.periodic = link.full_circle;
  const double step = (link.upper - link.lower) / (link.full_circle ? N : N - 1);
  for (int k = 0; k < N; ++k) {
    axis.q[k] = link.lower + step * k;
    axis.a[k] = link.rotates ? std::cos(axis.q[k]) : axis.q[k];
    axis.b[k] = link.rotates ? std::sin(axis.q[k]) : 0.0;
  }
  return axis;
}

// The usual full circle from -pi is tabulated once.
template <int N>
const Axis<N>& axis_of(const ReachLink& link, Axis<N>& storage) {
  static const Axis<N> circle = make_axis<N>({.full_circle = true, .lower = -0.5 * kTurn, .upper = 0.5 * kTurn});
  if (link.full_circle && link.lower == -0.5 * kTurn) return circle;
  storage = make_axis<N>(link);
  return storage;
}

Eigen::Vector3d moved(const ReachLink& link, double a, double b, const Eigen::Vector3d& v) {
  if (!link.rotates) return {v.x(), v.y(), v.z() + a};
  return {a * v.x() - b * v.y(), b * v.x() + a * v.y(), v.z()};
}

// Squared distance of the target from the circle or line that a point p of frame 0 sweeps when joint 0 moves freely.
// Its limits are left to their own search: a minimum inside them is a minimum without them, while the distance under
// limits has kinks where the nearest end changes, and two minima as close together as one likes on their two sides.
class Sweep {
 public:
  explicit Sweep(const ReachProblem& problem)
      : link_{problem.links[0]}, t_{problem.target}, rho_{std::hypot(t_.x(), t_.y())} {}

  template <int N>
  void squared_distance(const Eigen::Array<double, N, 1>& x, const Eigen::Array<double, N, 1>& y,
                        const Eigen::Array<double, N, 1>& z, Eigen::Array<double, N, 1>& result) const {
    if (link_.rotates) {
      result = ((x.square() + y.square()).sqrt() - rho_).square() + (z - t_.z()).square();
    } else {
      result = (x - t_.x()).square() + (y - t_.y()).square();
    }
  }

  // The value of joint 0 within its limits that brings p closest.
  [[nodiscard]] double best_value(const Eigen::Vector3d& p) const {
    if (!link_.rotates) return std::clamp(t_.z() - p.z(), link_.lower, link_.upper);
    double q = std::atan2(t_.y() * p.x() - t_.x() * p.y(), t_.x() * p.x() + t_.y() * p.y());
    q -= kTurn * std::floor((q - link_.lower) / kTurn);
    if (q <= link_.upper) return q;
    return q - link_.upper < link_.lower + kTurn - q ? link_.upper : link_.lower;
  }

 private:
  const ReachLink& link_;
  Eigen::Vector3d t_;
  double rho_;
};

// One row of the grid: joint 1 runs, `w` is the tip in the frame that moves with joint 1.
template <int N>
void evaluate_row(const Sweep& sweep, const ReachProblem& problem, const Axis<N>& axis, const Eigen::Vector3d& w,
                  Eigen::Array<double, N, 1>& row) {
  const ReachLink& base = problem.links[0];
  Eigen::Vector3d P0, P1, P2;
  if (problem.links[1].rotates) {
    P0 = base.p + base.R.col(2) * w.z();
    P1 = base.R.col(0) * w.x() + base.R.col(1) * w.y();
    P2 = base.R.col(1) * w.x() - base.R.col(0) * w.y();
  } else {
    P0 = base.p + base.R * w;
    P1 = base.R.col(2);
    P2.setZero();
  }
  const Eigen::Array<double, N, 1> x = P0.x() + axis.a * P1.x() + axis.b * P2.x();
  const Eigen::Array<double, N, 1> y = P0.y() + axis.a * P1.y() + axis.b * P2.y();
  const Eigen::Array<double, N, 1> z = P0.z() + axis.a * P1.z() + axis.b * P2.z();
  sweep.squared_distance<N>(x, y, z, row);
}

ReachJoints grid_start(const Sweep& sweep, const ReachProblem& problem, double q1, double q2) {
  const ReachLink& one = problem.links[1];
  const ReachLink& two = problem.links[2];
  Eigen::Vector3d w = one.p;
  if (problem.n == 3) {
    w += one.R * (two.rotates ? moved(two, std::cos(q2), std::sin(q2), two.p) : moved(two, q2, 0.0, two.p));
  }
  const Eigen::Vector3d v = one.rotates ? moved(one, std::cos(q1), std::sin(q1), w) : moved(one, q1, 0.0, w);
  return {sweep.best_value(problem.links[0].p + problem.links[0].R * v), q1, q2};
}

}  // namespace

double grid_step(const ReachProblem& problem, int j) {
  const ReachLink& link = problem.links[static_cast<std::size_t>(j)];
  const int points = problem.n == 2 ? kPointsOfOne : kPointsOfTwo;
  return (link.upper - link.lower) / (link.full_circle ? points : points - 1);
}

ReachJoints with_best_first_joint(const ReachProblem& problem, const ReachJoints& q) {
  ReachJoints inside = q;
  for (int j = 1; j < problem.n; ++j) {
    const ReachLink& link = problem.links[static_cast<std::size_t>(j)];
    if (link.rotates && (q[j] < link.lower || q[j] > link.upper)) {
      inside[j] -= kTurn * std::floor((q[j] - link.lower) / kTurn);
      // Past the upper limit: the nearer end of the gap.
      if (inside[j] > link.upper && inside[j] - link.upper > link.lower + kTurn - inside[j]) inside[j] = link.lower;
    }
    inside[j] = std::clamp(inside[j], link.lower, link.upper);
  }
  return grid_start(Sweep{problem}, problem, inside[1], inside[2]);
}

NearestList grid_minima_2(const ReachProblem& problem) {
  constexpr int kColumns = kPointsOfOne;
  const Sweep sweep{problem};
  Axis<kColumns> storage;
  const Axis<kColumns>& axis = axis_of(problem.links[1], storage);
  Eigen::Array<double, kColumns, 1> row;
  evaluate_row(sweep, problem, axis, problem.links[1].p, row);

  NearestList minima;
  for (int k = 0; k < kColumns; ++k) {
    const auto bettered_by = [&](int other) {
      if (other < 0 || other >= kColumns) {
        if (!axis.periodic) return false;
        other = other < 0 ? kColumns - 1 : 0;
      }
      return row[other] < row[k] || (row[other] == row[k] && other < k);
    };
    if (bettered_by(k - 1) || bettered_by(k + 1)) continue;
    minima.add({grid_start(sweep, problem, axis.q[k], 0.0), std::sqrt(row[k])});
  }
  return minima;
}

NearestList grid_minima_3(const ReachProblem& problem) {
  constexpr int kColumns = kPointsOfTwo;
  constexpr int kRows = kPointsOfTwo;
  const Sweep sweep{problem};
  Axis<kColumns> column_storage;
  Axis<kRows> row_storage;
  const Axis<kColumns>& axis1 = axis_of(problem.links[1], column_storage);
  const Axis<kRows>& axis2 = axis_of(problem.links[2], row_storage);
  std::array<Eigen::Array<double, kColumns, 1>, kRows> grid;
  const ReachLink& one = problem.links[1];
  for (int i = 0; i < kRows; ++i) {
    const Eigen::Vector3d w = one.p + one.R * moved(problem.links[2], axis2.a[i], axis2.b[i], problem.links[2].p);
    evaluate_row(sweep, problem, axis1, w, grid[static_cast<std::size_t>(i)]);
  }

  NearestList minima;
  for (int i = 0; i < kRows; ++i) {
    for (int k = 0; k < kColumns; ++k) {
      const double value = grid[static_cast<std::size_t>(i)][k];
      // Equal values count for the first of them, or a plateau would have no minimum, or very many.
      const auto bettered_by = [&](int other_i, int other_k) {
        if (other_i < 0 || other_i >= kRows) {
          if (!axis2.periodic) return false;
          other_i = other_i < 0 ? kRows - 1 : 0;
        }
        if (other_k < 0 || other_k >= kColumns) {
          if (!axis1.periodic) return false;
          other_k = other_k < 0 ? kColumns - 1 : 0;
        }
        const double other = grid[static_cast<std::size_t>(other_i)][other_k];
        return other < value || (other == value && other_i * kColumns + other_k < i * kColumns + k);
      };
      if (bettered_by(i, k - 1) || bettered_by(i, k + 1) || bettered_by(i - 1, k) || bettered_by(i + 1, k)) continue;
      if (bettered_by(i - 1, k - 1) || bettered_by(i - 1, k + 1) || bettered_by(i + 1, k - 1) ||
          bettered_by(i + 1, k + 1)) {
        continue;
      }
      minima.add({grid_start(sweep, problem, axis1.q[k], axis2.q[i]), std::sqrt(value)});
    }
  }
  return minima;
}

}  // namespace modsearch::internal
