#pragma once

// A set of poses that holds all of a region: what can be said of points that move with it. Internal to the problem
// floor.

#include <modsearch/kinematics/pose_region.hpp>
#include <optional>

namespace modsearch::detail {

/// Whether R is a rotation up to 1e-9: proofs leave others alone. What is less wrong moves what lies within some metres
/// by less than every proof leaves open.
[[nodiscard]] bool is_rotation(const Eigen::Matrix3d& R);

/// Every pose of a region is the centre, moved by at most the half axes of a box and turned by a bounded angle.
struct PoseEnclosure {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();     ///< the centre
  Eigen::Matrix3d half_axes_W = Eigen::Matrix3d::Zero();      ///< columns: half edges of the box of positions [m]
  double position_radius = 0.0;                               ///< no position is farther from the centre [m]
  double angle = 0.0;                                         ///< no pose is turned farther from the centre [rad]
  double turn = 0.0;                                          ///< chord(angle)
  Eigen::Matrix3d axes_C = Eigen::Matrix3d::Identity();       ///< columns: axes about which a pose may be freer to turn
  Eigen::Vector3d off_axis = Eigen::Vector3d::Constant(2.0);  ///< how far each is carried at most, of unit length

  /// How far turning carries a point at most that is `reach` or less from `p_C` [m]: beside what moves the origin.
  /// A turn Q by at most `angle` carries q by at most 2 sin(angle / 2) |q|. Where its rotation vector is at most s off
  /// an axis a, it carries a itself by at most s, and so q by at most s |q . a| + 2 sin(angle / 2) |q - (q . a) a|: a
  /// point on the axis of a free turn stays where it is.
  [[nodiscard]] double turned_by(const Eigen::Vector3d& p_C, double reach) const;
};

/// 2 sin(angle / 2): how far a turn by at most `angle` carries a point at distance 1 from its axis.
[[nodiscard]] double chord(double angle);

/// Nothing where positions are not bounded, or where frames of the region are no rotations.
///
/// Intervals on x, y, z and r_cyl in the frame of the first of these, on N_x, N_y, N_z likewise, and upper ends of
/// r_sph and Theta_R; others are left out, which only enlarges the set.
[[nodiscard]] std::optional<PoseEnclosure> enclosure(const PoseRegion& region);

}  // namespace modsearch::detail
