#pragma once

#include <modsearch/kinematics/arm_moves_internal.hpp>
#include <modsearch/kinematics/pose_region.hpp>
#include <modsearch/problem/smooth_program.hpp>
#include <span>
#include <vector>

namespace modsearch::detail {

/// Where the variables of one goal are in v = (x, q_1, q_2, ..): parameters in front, its joints from `q_at` on.
struct GoalColumns {
  int n_x = 0;
  Eigen::Index q_at = 0;

  /// Column of a variable of Move.
  [[nodiscard]] Eigen::Index of(int variable) const { return variable < n_x ? variable : q_at + variable - n_x; }
};

/// The rows of one goal of a smooth program: what its tolerances say of the pose of the tip, with exact derivatives.
///
/// With the offset p of the tip from the nominal position and the rotation vector r of R_WE R_WN^T, world axes, most
/// rows are components A p or A r. The others are |r|, or polar coordinates of p.
class PoseRows {
 public:
  PoseRows(const Eigen::Isometry3d& X_WN, GoalColumns columns) : X_WN_{X_WN}, columns_{columns} {}

  /// How many rows `tolerance` needs: a ball about the nominal (r_sph, r_cyl, Theta_R from 0) is a vector of rows.
  [[nodiscard]] static int count(const Tolerance& tolerance);
  /// Its rows are those from `first` on.
  void add(const Tolerance& tolerance, Eigen::Index first);

  /// Rows and their gradients, into a Jacobian whose entries here are 0.
  void evaluate(const Eigen::Isometry3d& X_WE, std::span<const Move> moves, SmoothProgram::Values& values) const;
  /// Adds sum_i multipliers_i * d2c_i/dv2 to `H` [n x n].
  void add_curvature(const Eigen::Isometry3d& X_WE, std::span<const Move> moves, const Eigen::VectorXd& multipliers,
                     Eigen::MatrixXd& H) const;

 private:
  enum class Form { kPosition, kRotation, kAngle, kPolar };
  struct Rows {
    Eigen::Index first = 0;
    int count = 1;
    Form form = Form::kPosition;
    Eigen::Matrix3d A = Eigen::Matrix3d::Identity();  // its first `count` rows count
    PoseRegion region;                                // kPolar: this tolerance alone
  };
  struct Curvature;
  [[nodiscard]] Curvature curvature(const Eigen::Isometry3d& X_WE, const Eigen::VectorXd& multipliers) const;

  Eigen::Isometry3d X_WN_;
  GoalColumns columns_;
  std::vector<Rows> rows_;
};

}  // namespace modsearch::detail
