#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/kinematics/reach_search_internal.hpp>
#include <numbers>

namespace modsearch::internal {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

template <int n>
using Vec = Eigen::Matrix<double, n, 1>;
template <int n>
using Mat = Eigen::Matrix<double, n, n>;

template <int n>
struct State {
  Vec<n> q;
  Eigen::Vector3d e;                                                     // tip - target [m]
  std::array<Eigen::Vector3d, static_cast<std::size_t>(n)> axis, lever;  // lever: d tip / d q
  double f = 0.0;                                                        // |e|^2 / 2
};

template <int n>
void evaluate(const ReachProblem& problem, State<n>& state) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d o = Eigen::Vector3d::Zero();
  std::array<Eigen::Vector3d, static_cast<std::size_t>(n)> origin;
  for (std::size_t j = 0; j < static_cast<std::size_t>(n); ++j) {
    const ReachLink& link = problem.links[j];
    const double q = state.q[static_cast<int>(j)];
    state.axis[j] = R.col(2);
    if (link.rotates) {
      const double c = std::cos(q);
      const double s = std::sin(q);
      const Eigen::Vector3d x = c * R.col(0) + s * R.col(1);
      R.col(1) = c * R.col(1) - s * R.col(0);
      R.col(0) = x;
    } else {
      o += q * R.col(2);
    }
    origin[j] = o;
    o += R * link.p;
    if (j + 1 < static_cast<std::size_t>(n)) R = (R * link.R).eval();
  }
  for (std::size_t j = 0; j < static_cast<std::size_t>(n); ++j) {
    state.lever[j] = problem.links[j].rotates ? state.axis[j].cross(o - origin[j]).eval() : state.axis[j];
  }
  state.e = o - problem.target;
  state.f = 0.5 * state.e.squaredNorm();
}

// Gradient and Hessian of |e|^2 / 2: the second derivative of the tip is axis_i x lever_j for i <= j.
template <int n>
void derivatives(const ReachProblem& problem, const State<n>& state, Vec<n>& g, Mat<n>& H) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    const int row = static_cast<int>(i);
    g[row] = state.e.dot(state.lever[i]);
    Eigen::Vector3d bent = Eigen::Vector3d::Zero();
    if (problem.links[i].rotates) bent = state.e.cross(state.axis[i]);
    for (std::size_t j = i; j < static_cast<std::size_t>(n); ++j) {
      const int column = static_cast<int>(j);
      H(row, column) = H(column, row) = (state.lever[i] + bent).dot(state.lever[j]);
    }
  }
}

// Solves A d = -g by Cholesky; false unless every pivot exceeds `least_pivot`.
template <int n>
bool newton_step(const Mat<n>& A, const Vec<n>& g, double least_pivot, Vec<n>& d) {
  Mat<n> L;
  for (int j = 0; j < n; ++j) {
    double pivot = A(j, j);
    for (int k = 0; k < j; ++k) pivot -= L(j, k) * L(j, k);
    if (!(pivot > least_pivot)) return false;
    L(j, j) = std::sqrt(pivot);
    for (int i = j + 1; i < n; ++i) {
      double entry = A(i, j);
      for (int k = 0; k < j; ++k) entry -= L(i, k) * L(j, k);
      L(i, j) = entry / L(j, j);
    }
  }
  for (int i = 0; i < n; ++i) {
    double entry = -g[i];
    for (int k = 0; k < i; ++k) entry -= L(i, k) * d[k];
    d[i] = entry / L(i, i);
  }
  for (int i = n - 1; i >= 0; --i) {
    double entry = d[i];
    for (int k = i + 1; k < n; ++k) entry -= L(k, i) * d[k];
    d[i] = entry / L(i, i);
  }
  return true;
}

template <int n>
Vec<n> projected(const ReachProblem& problem, Vec<n> q) {
  for (int j = 0; j < n; ++j) {
    const ReachLink& link = problem.links[static_cast<std::size_t>(j)];
    if (link.full_circle) {
      if (q[j] < link.lower || q[j] > link.upper) q[j] -= kTurn * std::floor((q[j] - link.lower) / kTurn);
    } else {
      q[j] = std::clamp(q[j], link.lower, link.upper);
    }
  }
  return q;
}

// Takes the joints out that press against a limit with more than `noise`.
template <int n>
void hold_pressed(const ReachProblem& problem, const Vec<n>& q, double noise, Vec<n>& g, Mat<n>& H) {
  for (int j = 0; j < n; ++j) {
    const ReachLink& link = problem.links[static_cast<std::size_t>(j)];
    if (link.full_circle) continue;
    const bool at_lower = q[j] <= link.lower;
    const bool at_upper = q[j] >= link.upper;
    if (!((at_lower && at_upper) || (at_lower && g[j] > noise) || (at_upper && g[j] < -noise))) continue;
    const double scale = H.diagonal().cwiseAbs().maxCoeff();
    g[j] = 0.0;
    H.row(j).setZero();
    H.col(j).setZero();
    H(j, j) = scale;  // neither flat nor steep, so that it does not speak in the eigenvalues
  }
}

template <int n>
void measure_flatness(const ReachProblem& problem, const State<n>& state, Descent& result) {
  constexpr double kSteep = 0.2;  // eigenvalues are needed only below this
  Vec<n> g;
  Mat<n> H;
  derivatives(problem, state, g, H);
  const double scale = H.diagonal().cwiseAbs().maxCoeff();
  hold_pressed(problem, state.q, 1e-9 * scale, g, H);
  Vec<n> unused;
  if (scale > 0.0 && newton_step<n>(H, g, kSteep * scale, unused)) return;
  Eigen::SelfAdjointEigenSolver<Mat<n>> eigen{H};
  const double largest = eigen.eigenvalues().cwiseAbs().maxCoeff();
  result.flatness = largest > 0.0 ? eigen.eigenvalues()[0] / largest : 0.0;
  Eigen::Index k = 0;
  eigen.eigenvectors().col(0).cwiseAbs().maxCoeff(&k);
  result.flat_direction.template head<n>() = eigen.eigenvectors().col(0) / eigen.eigenvectors()(k, 0);
}

template <int n>
Descent descend_n(const ReachProblem& problem, const ReachJoints& start, ReachWork& work) {
  constexpr int kIterations = 60;
  constexpr double kLongestStep = 0.8;    // [rad] or [m]; longer ones leave the valley that the grid has found
  constexpr double kQuadratic = 1e-7;     // an undamped step of this size leaves an error of about its square
  constexpr double kShortestStep = 1e-9;  // shorter ones change the distance by less than rounding
  constexpr double kFirstDamping = 1e-4;  // relative to the largest entry of the Hessian's diagonal; arbitrary
  State<n> state;
  state.q = projected<n>(problem, start.head<n>());
  evaluate(problem, state);
  ++work.forward;
  const double size = problem.target.squaredNorm() + (state.e + problem.target).squaredNorm();
  const double noise = 4.0 * std::numeric_limits<double>::epsilon() * size;  // of f
  double damping = 0.0;
  bool done = false;
  for (int iteration = 0; iteration < kIterations && !done; ++iteration) {
    ++work.iterations;
    Vec<n> g;
    Mat<n> H;
    derivatives(problem, state, g, H);
    hold_pressed(problem, state.q, 0.0, g, H);
    const double scale = H.diagonal().cwiseAbs().maxCoeff() + std::numeric_limits<double>::min();
    for (bool moved = false; !moved && !done;) {
      Vec<n> d;
      Mat<n> A = H;
      A.diagonal().array() += damping * scale;
      if (!newton_step<n>(A, g, 1e-12 * scale, d)) {
        damping = std::max(4.0 * damping, kFirstDamping);
        done = !(damping < 1e12);  // a matrix of NaN
        continue;
      }
      const double longest = d.cwiseAbs().maxCoeff();
      if (longest > kLongestStep) d *= kLongestStep / longest;
      State<n> trial;
      trial.q = projected<n>(problem, state.q + d);
      evaluate(problem, trial);
      ++work.forward;
      moved = trial.f <= state.f + std::min(noise, 1e-3 * state.f);
      done = longest < kShortestStep || (moved && damping == 0.0 && longest < kQuadratic);
      if (moved) {
        state = trial;
        damping = damping > 1e-3 * kFirstDamping ? 0.1 * damping : 0.0;
      } else {
        damping = std::max(4.0 * damping, kFirstDamping);
      }
    }
  }

  Descent result;
  result.end.q.setZero();
  result.end.q.template head<n>() = state.q;
  result.end.distance = state.e.norm();
  measure_flatness(problem, state, result);
  return result;
}

}  // namespace

Descent descend(const ReachProblem& problem, const ReachJoints& q, ReachWork& work) {
  return problem.n == 2 ? descend_n<2>(problem, q, work) : descend_n<3>(problem, q, work);
}

}  // namespace modsearch::internal
