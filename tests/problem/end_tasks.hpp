#pragma once

// Tasks about the end of an arm, for the proofs that it overlaps an obstacle: tolerances of many kinds, poses drawn in
// them, arms with random modules, boxes put next to them.

#include <algorithm>
#include <cmath>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/rng.hpp>
#include <numbers>
#include <optional>
#include <vector>

namespace modsearch::test {

constexpr double kTurn = 2.0 * std::numbers::pi;

inline Eigen::Vector3d random_vector(Rng& rng, double extent) {
  return {rng.uniform(-extent, extent), rng.uniform(-extent, extent), rng.uniform(-extent, extent)};
}

inline Eigen::Matrix3d rotation_of(const Eigen::Vector3d& r) {
  const double angle = r.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd{angle, r / angle}.toRotationMatrix();
}

inline Eigen::Matrix3d random_rotation(Rng& rng) {
  Eigen::Quaterniond q{rng.normal(), rng.normal(), rng.normal(), rng.normal()};
  return q.normalized().toRotationMatrix();
}

/// What a goal leaves open, and a way to draw from it: position p and rotation vector r of the deviation, each in its
/// frame T.
struct Looseness {
  std::vector<Tolerance> tolerances;
  Eigen::Matrix3d R_pN = Eigen::Matrix3d::Identity();  // frame of the position
  Eigen::Matrix3d R_rN = Eigen::Matrix3d::Identity();  // of the rotation
  Eigen::Vector3d p_lower = Eigen::Vector3d::Zero(), p_upper = Eigen::Vector3d::Zero();
  double p_ball = 1e9, p_cylinder = 1e9;
  Eigen::Vector3d r_lower = Eigen::Vector3d::Zero(), r_upper = Eigen::Vector3d::Zero();
  double r_ball = std::numbers::pi;

  /// A pose that the region at `X_WN` accepts.
  [[nodiscard]] Eigen::Isometry3d draw(const Eigen::Isometry3d& X_WN, Rng& rng) const {
    const auto in_box = [&](const Eigen::Vector3d& lower, const Eigen::Vector3d& upper) {
      return Eigen::Vector3d{rng.uniform(lower.x(), upper.x()), rng.uniform(lower.y(), upper.y()),
                             rng.uniform(lower.z(), upper.z())};
    };
    Eigen::Vector3d p;
    do {
      p = in_box(p_lower, p_upper);
    } while (p.norm() > p_ball || p.head<2>().norm() > p_cylinder);
    Eigen::Vector3d r;
    do {
      r = in_box(r_lower, r_upper);
    } while (r.norm() > r_ball);
    Eigen::Isometry3d D = Eigen::Isometry3d::Identity();
    D.translation() = R_pN.transpose() * p;
    D.linear() = rotation_of(R_rN.transpose() * r);
    return X_WN * D;
  }
};

/// Kinds 0 to 5: CoBRA's default; a free turn about z within a cone; the same about x, in a turned frame; a ball, and a
/// small angle; intervals that do not begin at 0; a wide cone with a cylinder.
constexpr int kLoosenesses = 6;
inline Looseness looseness(int kind, Rng& rng) {
  using P = Projection;
  Looseness l;
  const auto position = [&](const Eigen::Vector3d& lower, const Eigen::Vector3d& upper) {
    l.p_lower = lower;
    l.p_upper = upper;
    const P axes[] = {P::kX, P::kY, P::kZ};
    for (int a = 0; a < 3; ++a) l.tolerances.push_back({axes[a], lower[a], upper[a], l.R_pN});
  };
  const auto turn = [&](const Eigen::Vector3d& lower, const Eigen::Vector3d& upper) {
    l.r_lower = lower;
    l.r_upper = upper;
    const P axes[] = {P::kNx, P::kNy, P::kNz};
    for (int a = 0; a < 3; ++a) {
      if (upper[a] - lower[a] < kTurn) l.tolerances.push_back({axes[a], lower[a], upper[a], l.R_rN});
    }
  };
  const auto small_turn = [&](double angle) {
    l.r_lower.setConstant(-angle);
    l.r_upper.setConstant(angle);
    l.r_ball = angle;
    l.tolerances.push_back({P::kThetaR, 0.0, angle});
  };
  const Eigen::Vector3d millimetre = Eigen::Vector3d::Constant(1e-3);
  const double pi = std::numbers::pi;
  switch (kind) {
    case 0:
      position(-millimetre, millimetre);
      small_turn(pi / 360.0);
      break;
    case 1:
      position(-millimetre, millimetre);
      turn({-0.1, -0.1, -pi}, {0.1, 0.1, pi});
      break;
    case 2:
      l.R_pN = random_rotation(rng);
      l.R_rN = random_rotation(rng);
      position(-2.0 * millimetre, millimetre);
      turn({-pi, -0.05, -0.05}, {pi, 0.05, 0.05});
      break;
    case 3:
      l.p_ball = 2e-3;
      l.p_lower.setConstant(-l.p_ball);
      l.p_upper.setConstant(l.p_ball);
      l.tolerances.push_back({P::kRSph, 0.0, l.p_ball});
      small_turn(0.03);
      break;
    case 4:
      position({0.0, -1e-3, 0.01}, {0.004, 0.0, 0.015});
      turn({0.05, -0.1, 0.2}, {0.08, 0.1, 0.3});
      break;
    default:
      l.R_pN = random_rotation(rng);
      l.p_cylinder = 3e-3;
      l.p_lower = {-3e-3, -3e-3, -1e-3};
      l.p_upper = {3e-3, 3e-3, 5e-3};
      l.tolerances.push_back({P::kRCyl, 0.0, 3e-3, l.R_pN});
      l.tolerances.push_back({P::kZ, -1e-3, 5e-3, l.R_pN});
      turn({-0.3, -0.3, -pi}, {0.3, 0.3, pi});
      break;
  }
  return l;
}

/// A complete sequence of at most `most` types, each drawn from those that fit; a design ends where it may with
/// probability 1/4.
inline std::vector<int> random_sequence(const ModuleLibrary& library, int most, Rng& rng) {
  while (true) {
    std::vector<int> types;
    while (static_cast<int>(types.size()) < most) {
      const std::vector<int> next = library.successors(types);
      if (next.empty()) break;
      types.push_back(next[static_cast<std::size_t>(rng.index(static_cast<int>(next.size())))]);
      const bool may_end = library.complete(types);
      if (may_end && (library.successors(types).empty() || rng.uniform() < 0.25)) return types;
    }
  }
}

inline Eigen::VectorXd random_parameters(const ModuleLibrary& library, const std::vector<int>& types, Rng& rng) {
  const ParameterBox box = parameter_box(library, types);
  Eigen::VectorXd x(box.lower.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    // Half of them at an end: that is where proofs over boxes go wrong.
    const double u = rng.uniform();
    x[i] = u < 0.25 ? box.lower[i] : u < 0.5 ? box.upper[i] : rng.uniform(box.lower[i], box.upper[i]);
  }
  return x;
}

inline Eigen::VectorXd random_posture(const Chain& chain, Rng& rng) {
  Eigen::VectorXd q(chain.n_joints());
  for (int j = 0; j < chain.n_joints(); ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    q[j] = joint.full_circle() ? rng.uniform(-3.0, 3.0) : rng.uniform(joint.lower, joint.upper);
  }
  return q;
}

/// A box, sphere, cylinder or capsule somewhere about `p_W`.
inline Obstacle random_obstacle(const Eigen::Vector3d& p_W, Rng& rng) {
  PlacedShape placed;
  placed.X_FG.translation() = p_W + random_vector(rng, 0.15);
  if (rng.uniform() < 0.5) placed.X_FG.linear() = random_rotation(rng);
  const auto size = [&] { return rng.uniform() < 0.5 ? 0.25 : rng.uniform(0.02, 0.3); };
  switch (rng.index(5)) {
    case 0:
      placed.shape = Sphere{0.5 * size()};
      break;
    case 1:
      placed.shape = Cylinder{0.5 * size(), size()};
      break;
    case 2:
      placed.shape = Capsule{0.5 * size(), size()};
      break;
    default:
      placed.shape = Box{{size(), size(), size()}};
      break;
  }
  return {"obstacle", {placed}};
}

}  // namespace modsearch::test
