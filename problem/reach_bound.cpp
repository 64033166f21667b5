#include <modsearch/problem/reach_bound.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// How far from the nominal position a position of the region can be at most [m].
double position_slack(const PoseRegion& region) {
  double sphere = kInfinity;
  double radial = kInfinity;
  double axes[3] = {kInfinity, kInfinity, kInfinity};
  for (const Tolerance& tolerance : region.tolerances()) {
    const double extent = std::max(std::abs(tolerance.lower), std::abs(tolerance.upper));
    switch (tolerance.projection) {
      case Projection::kX:
      case Projection::kY:
      case Projection::kZ: {
        // Intervals of different frames bound different directions: only those of the nominal frame are combined.
        if (!tolerance.R_TN.isIdentity(1e-12)) break;
        double& axis = axes[static_cast<int>(tolerance.projection)];
        axis = std::min(axis, extent);
        break;
      }
      case Projection::kRSph:
        sphere = std::min(sphere, extent);
        break;
      case Projection::kRCyl:
        if (tolerance.R_TN.isIdentity(1e-12)) radial = std::min(radial, extent);
        break;
      case Projection::kPhiCyl:
      case Projection::kTheta:
      case Projection::kPhiSph:
      case Projection::kNx:
      case Projection::kNy:
      case Projection::kNz:
      case Projection::kThetaR:
        break;
    }
  }
  return std::min(sphere, std::hypot(std::min(radial, std::hypot(axes[0], axes[1])), axes[2]));
}

}  // namespace

ReachBound reach_bound(const Chain& chain, const ParameterBox& box, const Eigen::Vector3d& p_WB,
                       const PoseRegion& region) {
  ReachBound result;
  result.distance = (region.nominal().translation() - p_WB).norm();

  // length(x) <= fixed + rate . x for x >= 0: each segment by its constant part and its part per parameter. Where the
  // box is negative somewhere the whole box counts as a constant.
  const Eigen::Index n = box.lower.size();
  double fixed = 0.0;
  Eigen::VectorXd rate = Eigen::VectorXd::Zero(n);
  for (int j = 0; j <= chain.n_joints(); ++j) {
    const AffineVector& segment = chain.segment(j).translation;
    // The base may stand anywhere: its own place is not part of the length.
    fixed += (j == 0 ? segment.offset - p_WB : segment.offset).norm();
    for (const AffineVector::Term& term : segment.terms) {
      const double length = term.direction.norm();
      if (box.lower[term.parameter] >= 0.0) {
        rate[term.parameter] += length;
      } else {
        fixed += length * std::max(std::abs(box.lower[term.parameter]), std::abs(box.upper[term.parameter]));
      }
    }
  }
  for (const Joint& joint : chain.joints()) {
    if (!joint.rotates()) fixed += std::max(std::abs(joint.lower), std::abs(joint.upper));
  }
  result.span = fixed + rate.dot(box.upper);

  const double slack = position_slack(region);
  const double needed = result.distance - slack;
  constexpr double kRounding = 1e-9;
  result.possible = !(needed > result.span + kRounding);

  const Eigen::VectorXd mass_rate = chain.mass().gradient(static_cast<int>(n));
  result.least_mass = chain.mass().least(box.lower, box.upper);
  double missing = needed - kRounding - fixed;
  std::vector<Eigen::Index> order;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (mass_rate[i] > 0.0) {
      missing -= rate[i] * box.lower[i];
      order.push_back(i);
    } else {
      missing -= rate[i] * box.upper[i];  // lengthening it costs nothing
    }
  }
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return rate[a] * mass_rate[b] > rate[b] * mass_rate[a];
  });
  for (const Eigen::Index i : order) {
    if (missing <= 0.0 || rate[i] <= 0.0) break;
    const double by = std::min(missing / rate[i], box.upper[i] - box.lower[i]);
    result.least_mass += by * mass_rate[i];
    missing -= by * rate[i];
  }
  return result;
}

}  // namespace modsearch
