#pragma once

#include <Eigen/Geometry>
#include <string_view>
#include <vector>

namespace modsearch {

/// One coordinate of the deviation D = nominal^-1 * actual of a pose (CoBRA's tolerance projections).
///
/// With p the translation of D, rotated into the tolerance's frame, and r the rotation vector of D (axis times angle):
/// kX, kY, kZ: components of p [m]; kRCyl = hypot(p_x, p_y) [m]; kPhiCyl = atan2(p_y, p_x) [rad]; kRSph = |p| [m];
/// kTheta: inclination of p from +z in [0, pi]; kPhiSph = atan2(p_y, p_x) [rad]; kNx, kNy, kNz: components of r,
/// rotated into the tolerance's frame [rad]; kThetaR = |r| [rad], at most pi (at exactly pi r has two signs, one is
/// taken).
enum class Projection { kX, kY, kZ, kRCyl, kPhiCyl, kRSph, kTheta, kPhiSph, kNx, kNy, kNz, kThetaR };

/// The name in files: "x", "r_cyl", "Theta_R", ...
[[nodiscard]] std::string_view name(Projection projection);

/// A closed interval for one projection. Azimuths (kPhiCyl, kPhiSph) are points on a circle and count modulo whole
/// turns: [3 pi / 4, 5 pi / 4] is the quarter about -x.
struct Tolerance {
  Projection projection = Projection::kRSph;
  double lower = 0.0;  ///< [m] or [rad]
  double upper = 0.0;
  /// Rotation from the nominal frame's axes to those the projection is taken in, R_TN: p_T = R_TN * p_N.
  /// Identity: the nominal frame. The nominal's own rotation R_WN: the world's axes.
  Eigen::Matrix3d R_TN = Eigen::Matrix3d::Identity();
};

/// The set of poses a goal accepts: all listed intervals hold; what is not listed is free.
class PoseRegion {
 public:
  /// Intervals are closed, with this slack in their own unit.
  static constexpr double kSlack = 1e-12;

  /// Throws std::invalid_argument for reversed or NaN intervals, and for frames that are not finite.
  PoseRegion(const Eigen::Isometry3d& X_WN, std::vector<Tolerance> tolerances);
  /// Positions within `radius` [m] of `p_W`, any orientation.
  [[nodiscard]] static PoseRegion ball(const Eigen::Vector3d& p_W, double radius);
  /// CoBRA's default: 1 mm along each nominal axis and 0.5 degrees of rotation.
  [[nodiscard]] static PoseRegion with_default_tolerances(const Eigen::Isometry3d& X_WN);

  [[nodiscard]] const Eigen::Isometry3d& nominal() const { return X_WN_; }
  [[nodiscard]] const std::vector<Tolerance>& tolerances() const { return tolerances_; }
  /// Positions in a ball about the nominal one, and nothing else: the case with exact answers and proofs.
  [[nodiscard]] bool is_ball() const;
  /// Whether any interval speaks of the orientation.
  [[nodiscard]] bool constrains_orientation() const;

  /// All intervals hold at `X_WE` (never for a pose that is not finite).
  [[nodiscard]] bool contains(const Eigen::Isometry3d& X_WE) const;
  /// Value of each projection [n_tolerances], in its unit.
  [[nodiscard]] Eigen::VectorXd values(const Eigen::Isometry3d& X_WE) const;
  /// d values / d (linear and angular velocity of E, world axes) [n_tolerances x 6]; where a projection is not
  /// differentiable (r_sph at 0, ...) the limit along a fixed direction, and 0 where there is none (phi on the z axis);
  /// always finite.
  [[nodiscard]] Eigen::Matrix<double, Eigen::Dynamic, 6> jacobian(const Eigen::Isometry3d& X_WE) const;
  /// How far outside its interval each projection is, signed (above > 0, below < 0, inside 0) [n_tolerances]; azimuths
  /// the shorter way round.
  [[nodiscard]] Eigen::VectorXd violations(const Eigen::Isometry3d& X_WE) const;

 private:
  Eigen::Isometry3d X_WN_;
  std::vector<Tolerance> tolerances_;
};

}  // namespace modsearch
