#include <algorithm>
#include <cmath>
#include <modsearch/problem/pose_enclosure_internal.hpp>
#include <numbers>

namespace modsearch::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = std::numbers::pi;
constexpr double kSameFrame = 1e-9;  // of the entries of rotations

bool is_position(Projection projection) {
  return projection == Projection::kX || projection == Projection::kY || projection == Projection::kZ ||
         projection == Projection::kRCyl;
}

bool is_rotation_component(Projection projection) {
  return projection == Projection::kNx || projection == Projection::kNy || projection == Projection::kNz;
}

// A box in a frame T, from the intervals that are taken in it.
struct Intervals {
  Eigen::Matrix3d R_TN = Eigen::Matrix3d::Identity();
  Eigen::Vector3d lower;
  Eigen::Vector3d upper;
  double radius = kInfinity;  // of a ball about 0 that holds all of it

  explicit Intervals(double extent)
      : lower{Eigen::Vector3d::Constant(-extent)}, upper{Eigen::Vector3d::Constant(extent)} {}
  void cut(int axis, double from, double to) {
    lower[axis] = std::max(lower[axis], from);
    upper[axis] = std::min(upper[axis], to);
  }
  [[nodiscard]] Eigen::Vector3d middle() const { return 0.5 * (lower + upper); }
  [[nodiscard]] Eigen::Vector3d half() const { return 0.5 * (upper - lower); }
  // Of a ball about the middle.
  [[nodiscard]] double radius_about_middle() const { return std::min(half().norm(), radius + middle().norm()); }
};

template <typename Counts>
Intervals gathered(const PoseRegion& region, double extent, Projection ball, const Counts& counts) {
  Intervals result{extent};
  bool framed = false;
  for (const Tolerance& tolerance : region.tolerances()) {
    if (tolerance.projection == ball) {
      result.radius = std::min(result.radius, std::max(tolerance.upper, 0.0));
      continue;
    }
    if (!counts(tolerance.projection) || !is_rotation(tolerance.R_TN)) continue;
    if (!framed) result.R_TN = tolerance.R_TN;
    framed = true;
    if ((tolerance.R_TN - result.R_TN).cwiseAbs().maxCoeff() > kSameFrame) continue;
    switch (tolerance.projection) {
      case Projection::kX:
      case Projection::kNx:
        result.cut(0, tolerance.lower, tolerance.upper);
        break;
      case Projection::kY:
      case Projection::kNy:
        result.cut(1, tolerance.lower, tolerance.upper);
        break;
      case Projection::kZ:
      case Projection::kNz:
        result.cut(2, tolerance.lower, tolerance.upper);
        break;
      case Projection::kRCyl:
        result.cut(0, -tolerance.upper, tolerance.upper);
        result.cut(1, -tolerance.upper, tolerance.upper);
        break;
      case Projection::kPhiCyl:
      case Projection::kRSph:
      case Projection::kTheta:
      case Projection::kPhiSph:
      case Projection::kThetaR:
        break;
    }
  }
  for (int axis = 0; axis < 3; ++axis) result.cut(axis, -result.radius, result.radius);
  return result;
}

}  // namespace

bool is_rotation(const Eigen::Matrix3d& R) {
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kSameFrame && R.determinant() > 0.0;
}

double chord(double angle) { return 2.0 * std::sin(0.5 * std::min(angle, kPi)); }

double PoseEnclosure::turned_by(const Eigen::Vector3d& p_C, double reach) const {
  double least = turn * (p_C.norm() + reach);
  for (int a = 0; a < 3; ++a) {
    if (off_axis[a] >= turn) continue;  // no axis to speak of: its parts add up to more
    const double along = std::abs(axes_C.col(a).dot(p_C));
    const double across = (p_C - axes_C.col(a).dot(p_C) * axes_C.col(a)).norm();
    least = std::min(least, off_axis[a] * (along + reach) + turn * (across + reach));
  }
  return least;
}

std::optional<PoseEnclosure> enclosure(const PoseRegion& region) {
  if (!is_rotation(region.nominal().linear())) return std::nullopt;
  const Intervals positions = gathered(region, kInfinity, Projection::kRSph, is_position);
  const Intervals turns = gathered(region, kPi, Projection::kThetaR, is_rotation_component);
  const bool bounded = positions.lower.allFinite() && positions.upper.allFinite();
  const bool empty =
      (positions.lower.array() > positions.upper.array()).any() || (turns.lower.array() > turns.upper.array()).any();
  if (!bounded || empty) return std::nullopt;

  PoseEnclosure result;
  const Eigen::Matrix3d R_WN = region.nominal().linear();
  const Eigen::Vector3d r_N = turns.R_TN.transpose() * turns.middle();
  result.X_WC = region.nominal();
  result.X_WC.translation() += R_WN * positions.R_TN.transpose() * positions.middle();
  result.half_axes_W = R_WN * positions.R_TN.transpose() * positions.half().asDiagonal();
  result.position_radius = positions.radius_about_middle();
  // Two rotation vectors are never closer than the turn from the one rotation to the other: the exponential map of
  // rotations shortens (its left Jacobian has no singular value above 1).
  result.angle = std::min(kPi, turns.radius_about_middle());
  result.turn = chord(result.angle);
  if (r_N.norm() > 0.0) {
    result.X_WC.rotate(Eigen::AngleAxisd{r_N.norm(), r_N.normalized()});
    return result;
  }
  // The axis a goes to cos(phi) = 1 - (1 - cos|r|) (1 - (a . r)^2 / |r|^2) >= 1 - (|r|^2 - (a . r)^2) / 2 of itself, so
  // that it moves by 2 sin(phi / 2) <= sqrt(|r|^2 - (a . r)^2), the part of r across it.
  result.axes_C = turns.R_TN.transpose();
  const Eigen::Vector3d half = turns.half();
  for (int a = 0; a < 3; ++a) {
    result.off_axis[a] = std::min({std::hypot(half[(a + 1) % 3], half[(a + 2) % 3]), turns.radius, 2.0});
  }
  return result;
}

}  // namespace modsearch::detail
