#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/kinematics/interruption.hpp>
#include <modsearch/kinematics/local_ik_internal.hpp>
#include <modsearch/kinematics/low_discrepancy.hpp>
#include <numbers>

namespace modsearch::internal {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

// Every interval drawn in by a hair: a search that converges to the end of an interval lands inside the true one.
PoseRegion drawn_in(const PoseRegion& region) {
  constexpr double kHair = 1e-8;  // [m] or [rad]: far above rounding, far below any tolerance that matters
  std::vector<Tolerance> tolerances = region.tolerances();
  for (Tolerance& tolerance : tolerances) {
    const double hair = std::min(kHair, 0.25 * (tolerance.upper - tolerance.lower));
    tolerance.lower += hair;
    tolerance.upper -= hair;
  }
  return {region.nominal(), std::move(tolerances)};
}

// The components whose length a projection is, or the projection itself.
std::vector<Projection> components_of(Projection projection) {
  if (projection == Projection::kRSph) return {Projection::kX, Projection::kY, Projection::kZ};
  if (projection == Projection::kRCyl) return {Projection::kX, Projection::kY};
  if (projection == Projection::kThetaR) return {Projection::kNx, Projection::kNy, Projection::kNz};
  return {projection};
}

PoseRegion component_region(const PoseRegion& region) {
  std::vector<Tolerance> rows;
  for (const Tolerance& tolerance : region.tolerances()) {
    for (const Projection projection : components_of(tolerance.projection)) {
      rows.push_back({.projection = projection, .lower = 0.0, .upper = 0.0, .R_TN = tolerance.R_TN});
    }
  }
  return {region.nominal(), std::move(rows)};
}

}  // namespace

Residuals::Residuals(const PoseRegion& region) : region_{region}, components_{component_region(region)} {
  int row = 0;
  for (const Tolerance& tolerance : region.tolerances()) {
    blocks_.push_back({row, static_cast<int>(components_of(tolerance.projection).size())});
    row += blocks_.back().rows;
  }
}

Eigen::VectorXd Residuals::at(const Eigen::Isometry3d& X_WE) const {
  const Eigen::VectorXd violations = region_.violations(X_WE);
  Eigen::VectorXd result = components_.values(X_WE);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    auto v = result.segment(blocks_[i].first, blocks_[i].rows);
    const double violation = violations[static_cast<Eigen::Index>(i)];
    if (blocks_[i].rows == 1) {
      v[0] = violation;
    } else if (const double length = v.norm(); length > 0.0) {
      v *= violation / length;
    } else {
      v[0] = violation;
    }
  }
  return result;
}

Eigen::Matrix<double, Eigen::Dynamic, 6> Residuals::jacobian(const Eigen::Isometry3d& X_WE) const {
  const Eigen::VectorXd violations = region_.violations(X_WE);
  const Eigen::VectorXd values = components_.values(X_WE);
  Eigen::Matrix<double, Eigen::Dynamic, 6> J = components_.jacobian(X_WE);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const double violation = violations[static_cast<Eigen::Index>(i)];
    auto rows = J.middleRows(blocks_[i].first, blocks_[i].rows);
    if (violation == 0.0) {
      rows.setZero();
    } else if (blocks_[i].rows > 1) {
      // v (1 - b / |v|), b the end of the interval, has the derivative k I + (1 - k) u u^T with u = v / |v| and
      // k = (|v| - b) / |v|.
      const Eigen::VectorXd v = values.segment(blocks_[i].first, blocks_[i].rows);
      const double length = v.norm();
      if (length == 0.0) continue;
      const double k = violation / length;
      const Eigen::VectorXd u = v / length;
      rows = (k * rows + (1.0 - k) * u * (u.transpose() * rows)).eval();
    }
  }
  return J;
}

Verdict judge(const Arm& arm, const PoseRegion& region, const Eigen::VectorXd& q) {
  Posture posture;
  arm.forward(q.data(), posture);
  Verdict verdict;
  verdict.q = q;
  verdict.reached = region.contains(posture.tip);
  verdict.violation = verdict.reached ? 0.0 : region.violations(posture.tip).norm();
  verdict.position_error = (posture.tip.translation() - region.nominal().translation()).norm();
  return verdict;
}

LocalIk::LocalIk(const Arm& arm, const PoseRegion& region, int max_iterations)
    : arm_{arm},
      region_{region},
      ball_{region.is_ball()},
      residuals_{drawn_in(region)},
      max_iterations_{max_iterations} {
  const int n = arm.n_joints();
  lower_ = arm.chain().lower_limits();
  upper_ = arm.chain().upper_limits();
  double span = 1.0 + (region.nominal().translation() - arm.segment(0).translation()).norm();
  for (int j = 1; j <= n; ++j) span += arm.segment(j).translation().norm();
  for (int j = 0; j < n; ++j) {
    const Joint& joint = arm.chain().joints()[static_cast<std::size_t>(j)];
    full_circle_.push_back(joint.full_circle());
    if (joint.full_circle()) {
      if (lower_[j] <= -0.5 * kTurn && upper_[j] >= 0.5 * kTurn) {
        lower_[j] = -0.5 * kTurn;
      } else if (!std::isfinite(lower_[j])) {
        lower_[j] = upper_[j] - kTurn;
      }
      upper_[j] = lower_[j] + kTurn;
    }
    if (!std::isfinite(lower_[j])) lower_[j] = std::min(0.0, upper_[j]) - 4.0 * span;
    if (!std::isfinite(upper_[j])) upper_[j] = std::max(0.0, lower_[j]) + 4.0 * span;
  }
  gradient_.resize(n);
  hessian_.resize(n, n);
  jacobian_.resize(3, n);
  factor_.resize(n, n);
  step_.resize(n);
}

Eigen::VectorXd LocalIk::start(int index) const {
  const Eigen::VectorXd u = halton(index, arm_.n_joints());
  return lower_ + u.cwiseProduct(upper_ - lower_);
}

void LocalIk::project(Eigen::VectorXd& q) const {
  for (int j = 0; j < q.size(); ++j) {
    if (full_circle_[static_cast<std::size_t>(j)] && (q[j] < lower_[j] || q[j] > upper_[j])) {
      q[j] -= kTurn * std::floor((q[j] - lower_[j]) / kTurn);
    }
    q[j] = std::clamp(q[j], lower_[j], upper_[j]);
  }
}

double LocalIk::cost(const Eigen::VectorXd& q) {
  ++forward_;
  arm_.forward(q.data(), posture_);
  if (ball_) {
    residual_ = posture_.tip.translation() - region_.nominal().translation();
  } else {
    residual_ = residuals_.at(posture_.tip);
  }
  return 0.5 * residual_.squaredNorm();
}

// Of half the squared residual at the posture of the last cost(). Exact for a ball: Gauss-Newton stalls at the edge of
// the arm's reach, where the Jacobian is singular and the distance is not zero.
void LocalIk::derivatives(const Eigen::VectorXd& q) {
  if (!ball_) {
    const Eigen::MatrixXd J = residuals_.jacobian(posture_.tip) * arm_.tip_jacobian_q(posture_);
    gradient_.noalias() = J.transpose() * residual_;
    hessian_.noalias() = J.transpose() * J;
    return;
  }
  const Eigen::Vector3d e = residual_;
  const Eigen::Vector3d p_W = posture_.tip.translation();
  const std::vector<Joint>& joints = arm_.chain().joints();
  for (int j = 0; j < q.size(); ++j) {
    const Eigen::Vector3d axis = posture_.axis(j);
    if (joints[static_cast<std::size_t>(j)].rotates()) {
      jacobian_.col(j) = axis.cross(p_W - posture_.origin(j));
    } else {
      jacobian_.col(j) = axis;
    }
    gradient_[j] = jacobian_.col(j).dot(e);
  }
  for (int i = 0; i < q.size(); ++i) {
    Eigen::Vector3d row = jacobian_.col(i);
    if (joints[static_cast<std::size_t>(i)].rotates()) row += e.cross(posture_.axis(i));
    for (int j = i; j < q.size(); ++j) hessian_(i, j) = hessian_(j, i) = row.dot(jacobian_.col(j));
  }
}

// step_ = -(hessian_ + damping I)^-1 gradient_ by Cholesky's method; false if the matrix is not positive definite. By
// hand: for a handful of joints the calls of a general one cost more than the arithmetic.
bool LocalIk::solve_damped(double damping) {
  const Eigen::Index n = gradient_.size();
  for (Eigen::Index j = 0; j < n; ++j) {
    double pivot = hessian_(j, j) + damping;
    for (Eigen::Index k = 0; k < j; ++k) pivot -= factor_(k, j) * factor_(k, j);
    if (!(pivot > 0.0)) return false;
    const double root = std::sqrt(pivot);
    factor_(j, j) = root;
    for (Eigen::Index i = j + 1; i < n; ++i) {  // factor_ holds L^T: column i is row i of L
      double sum = hessian_(i, j);
      for (Eigen::Index k = 0; k < j; ++k) sum -= factor_(k, i) * factor_(k, j);
      factor_(j, i) = sum / root;
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    double sum = -gradient_[i];
    for (Eigen::Index k = 0; k < i; ++k) sum -= factor_(k, i) * step_[k];
    step_[i] = sum / factor_(i, i);
  }
  for (Eigen::Index i = n - 1; i >= 0; --i) {
    double sum = step_[i];
    for (Eigen::Index k = i + 1; k < n; ++k) sum -= factor_(i, k) * step_[k];
    step_[i] = sum / factor_(i, i);
  }
  return true;
}

bool LocalIk::pressed(const Eigen::VectorXd& q, int j) const {
  if (full_circle_[static_cast<std::size_t>(j)]) return false;
  return (q[j] <= lower_[j] && gradient_[j] > 0.0) || (q[j] >= upper_[j] && gradient_[j] < 0.0) ||
         lower_[j] == upper_[j];
}

Verdict LocalIk::refine(Eigen::VectorXd q) {
  interruption_point();
  constexpr double kZero = 1e-28;          // of the cost: nothing left to gain
  constexpr double kShortestStep = 1e-10;  // [rad] or [m]
  constexpr double kNothingToGain = 1e-16;
  constexpr double kLongestStep = 1.0;    // longer steps leave the range where the linear model means anything
  constexpr double kLeastDamping = 1e-9;  // redundant arms have a singular Hessian
  const auto n = q.size();
  project(q);
  double f = cost(q);
  double damping = 1e-3;  // relative to the largest diagonal entry; arbitrary
  bool done = f <= kZero;
  for (int iteration = 0; iteration < max_iterations_ && !done; ++iteration) {
    ++iterations_;
    derivatives(q);
    for (int j = 0; j < n; ++j) {
      if (!pressed(q, j)) continue;
      gradient_[j] = 0.0;
      hessian_.row(j).setZero();
      hessian_.col(j).setZero();
      hessian_(j, j) = 1.0;
    }
    if (gradient_.cwiseAbs().maxCoeff() == 0.0) break;
    const double scale = std::max(hessian_.diagonal().cwiseAbs().maxCoeff(), std::numeric_limits<double>::min());
    for (bool moved = false; !moved && !done;) {
      if (!solve_damped(damping * scale)) {
        damping *= 4.0;
        done = !(damping < 1e12);
        continue;
      }
      // What the step promises is below the rounding of f: this is the minimum, and shorter steps would only dither.
      if (-gradient_.dot(step_) <= kNothingToGain * f) {
        done = true;
        break;
      }
      const double longest = step_.cwiseAbs().maxCoeff();
      if (longest > kLongestStep) step_ *= kLongestStep / longest;
      trial_ = q + step_;
      project(trial_);
      const double f_trial = cost(trial_);
      moved = f_trial < f;
      done = longest < kShortestStep || f_trial <= kZero || !std::isfinite(f_trial);
      if (moved) {
        q.swap(trial_);
        f = f_trial;
        damping = std::max(0.2 * damping, kLeastDamping);
      } else {
        damping *= 4.0;
      }
    }
  }
  return judge(arm_, region_, q);
}

std::vector<Eigen::VectorXd> LocalIk::scan() {
  constexpr std::size_t kMostStarts = 96;
  const int n = arm_.n_joints();
  const int points = n == 1 ? 256 : n == 2 ? 48 : 20;  // per joint
  int total = 1;
  for (int j = 0; j < n; ++j) total *= points;

  const auto posture_of = [&](int index) {
    Eigen::VectorXd q(n);
    for (int j = 0; j < n; ++j, index /= points) {
      const int steps = full_circle_[static_cast<std::size_t>(j)] ? points : points - 1;
      q[j] = lower_[j] + (upper_[j] - lower_[j]) * (index % points) / steps;
    }
    return q;
  };
  std::vector<double> costs(static_cast<std::size_t>(total));
  for (int i = 0; i < total; ++i) costs[static_cast<std::size_t>(i)] = cost(posture_of(i));

  // Points that no neighbour along a joint betters; equal ones count for the first.
  const auto is_minimum = [&](int index) {
    int stride = 1;
    for (int j = 0; j < n; ++j, stride *= points) {
      const int k = (index / stride) % points;
      for (const int side : {-1, 1}) {
        int neighbour = k + side;
        if (neighbour < 0 || neighbour >= points) {
          if (!full_circle_[static_cast<std::size_t>(j)]) continue;
          neighbour = (neighbour + points) % points;
        }
        const int other = index + (neighbour - k) * stride;
        const double a = costs[static_cast<std::size_t>(index)];
        const double b = costs[static_cast<std::size_t>(other)];
        if (b < a || (b == a && other < index)) return false;
      }
    }
    return true;
  };
  std::vector<int> minima;
  for (int i = 0; i < total; ++i) {
    if (is_minimum(i)) minima.push_back(i);
  }
  std::stable_sort(minima.begin(), minima.end(), [&](int a, int b) {
    return costs[static_cast<std::size_t>(a)] < costs[static_cast<std::size_t>(b)];
  });
  if (minima.size() > kMostStarts) minima.resize(kMostStarts);
  std::vector<Eigen::VectorXd> result;
  for (const int i : minima) result.push_back(posture_of(i));
  return result;
}

}  // namespace modsearch::internal
