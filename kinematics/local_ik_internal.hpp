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
  void derivatives(const Eigen::VectorXd& q);
  void project(Eigen::VectorXd& q) const;
  [[nodiscard]] bool pressed(const Eigen::VectorXd& q, int j) const;

  const Arm& arm_;
  const PoseRegion& region_;
  PoseRegion aim_;  // a hair smaller than the region, so that the search ends inside it
  int max_iterations_;
  Eigen::VectorXd lower_, upper_;  // finite
  std::vector<bool> full_circle_;
  Posture posture_;      // of the last cost()
  Eigen::VectorXd residual_;
  Eigen::VectorXd gradient_;
  Eigen::MatrixXd hessian_;
  std::int64_t iterations_ = 0;
  std::int64_t forward_ = 0;
};

}  // namespace modsearch::internal
