#pragma once

// Internal: local search for postures that bring the tip into a pose region, for chains of any length.

#include <modsearch/kinematics/arm.hpp>
#include <modsearch/kinematics/inverse_kinematics.hpp>
#include <modsearch/kinematics/pose_region.hpp>
#include <vector>

namespace modsearch::internal {

/// Where a posture leaves the tip.
struct Verdict {
  Eigen::VectorXd q;            ///< within the limits [n_joints]
  double violation = 0.0;       ///< norm of the region's violations
  double position_error = 0.0;  ///< distance from the nominal position [m]
  bool reached = false;         ///< the region contains the tip
};
[[nodiscard]] Verdict judge(const Arm& arm, const PoseRegion& region, const Eigen::VectorXd& q);

/// Violations of a region as residuals whose squares add up to the same sum, but that a Gauss-Newton method
/// understands.
///
/// A violated length (r_sph, r_cyl, Theta_R) counts as the vector from the allowed shell to the point, not as a number:
/// of the number's gradient alone the method would believe that all directions across it are free.
class Residuals {
 public:
  explicit Residuals(const PoseRegion& region);

  [[nodiscard]] Eigen::VectorXd at(const Eigen::Isometry3d& X_WE) const;
  /// d residuals / d (linear and angular velocity of E) [rows x 6]; zero rows where the interval holds.
  [[nodiscard]] Eigen::Matrix<double, Eigen::Dynamic, 6> jacobian(const Eigen::Isometry3d& X_WE) const;

 private:
  struct Block {
    int first = 0;  // row
    int rows = 1;
  };
  std::vector<Block> blocks_;
  PoseRegion region_;      // the intervals themselves
  PoseRegion components_;  // one projection per row
};

/// Projected Levenberg-Marquardt searches for one arm and region: least violation, or least distance for a ball.
class LocalIk {
 public:
  LocalIk(const Arm& arm, const PoseRegion& region, int max_iterations);

  /// Start `index` of the fixed set: the middle of the limits, then Halton points; full circles over [-pi, pi].
  [[nodiscard]] Eigen::VectorXd start(int index) const;
  /// Promising starts on a dense grid, most promising first. For at most three joints.
  [[nodiscard]] std::vector<Eigen::VectorXd> scan();
  /// The end of the search from `q`.
  [[nodiscard]] Verdict refine(Eigen::VectorXd q);

  [[nodiscard]] std::int64_t iterations() const { return iterations_; }
  [[nodiscard]] std::int64_t forward() const { return forward_; }

 private:
  double cost(const Eigen::VectorXd& q);
  bool solve_damped(double damping);
  void derivatives(const Eigen::VectorXd& q);
  void project(Eigen::VectorXd& q) const;
  [[nodiscard]] bool pressed(const Eigen::VectorXd& q, int j) const;

  const Arm& arm_;
  const PoseRegion& region_;
  bool ball_;
  Residuals residuals_;  // of a region a hair smaller, so that the search ends inside
  int max_iterations_;
  Eigen::VectorXd lower_, upper_;  // finite
  std::vector<bool> full_circle_;
  // Memory of the search's loops, which must not allocate.
  Posture posture_;  // of the last cost()
  Eigen::VectorXd residual_;
  Eigen::VectorXd gradient_;
  Eigen::MatrixXd hessian_;
  Eigen::Matrix3Xd jacobian_;  // of the tip's position in q; of balls
  Eigen::MatrixXd factor_;
  Eigen::VectorXd step_;
  Eigen::VectorXd trial_;
  std::int64_t iterations_ = 0;
  std::int64_t forward_ = 0;
};

}  // namespace modsearch::internal
