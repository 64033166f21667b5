#pragma once

#include <modsearch/kinematics/chain.hpp>

namespace modsearch {

/// Where every frame of an arm is, for one q.
struct Posture {
  std::vector<Eigen::Isometry3d> frames;                  ///< X_WF [n_joints + 1], see Chain
  Eigen::Isometry3d tip = Eigen::Isometry3d::Identity();  ///< X_WE

  /// Axis of joint j in the world, unit length, and a point on it [m].
  [[nodiscard]] Eigen::Vector3d axis(int j) const { return frames[static_cast<std::size_t>(j) + 1].linear().col(2); }
  [[nodiscard]] Eigen::Vector3d origin(int j) const { return frames[static_cast<std::size_t>(j) + 1].translation(); }
};

/// A collision shape of an arm with its sizes filled in.
struct ArmGeometry {
  int body = 0;   ///< index into Chain::bodies()
  int frame = 0;  ///< frame it moves with
  Shape shape;
  Eigen::Isometry3d X_FG = Eigen::Isometry3d::Identity();
  double bounding_radius = 0.0;  ///< about the origin of G [m]
};

/// A chain with its lengths filled in: the robot that moves. Forward kinematics and exact derivatives in q and in x.
class Arm {
 public:
  /// See Chain::at. `chain` must outlive the arm.
  Arm(const Chain& chain, const Eigen::VectorXd& x);
  /// Changes the lengths without allocating; throws like the constructor.
  void set_parameters(const Eigen::VectorXd& x);

  [[nodiscard]] const Chain& chain() const { return *chain_; }
  [[nodiscard]] int n_joints() const { return chain_->n_joints(); }
  [[nodiscard]] const Eigen::VectorXd& parameters() const { return x_; }
  [[nodiscard]] double mass() const { return chain_->mass(x_); }
  [[nodiscard]] const std::vector<ArmGeometry>& geometries() const { return geometries_; }
  /// Transform of Chain::segment(j) at the arm's parameters.
  [[nodiscard]] const Eigen::Isometry3d& segment(int j) const { return segments_[static_cast<std::size_t>(j)]; }

  /// Forward kinematics at `q` [n_joints]. Throws std::invalid_argument if q.size() != n_joints().
  [[nodiscard]] Posture forward(const Eigen::VectorXd& q) const;
  /// The same into a posture that is used again and again: the hot loops must not allocate. `q`: n_joints numbers.
  void forward(const double* q, Posture& posture) const;

  /// d p / d q of a point that moves with `frame` and is at `p_W` now: [3 x n_joints], zero for joints at or after it.
  [[nodiscard]] Eigen::Matrix3Xd point_jacobian_q(const Posture& posture, int frame, const Eigen::Vector3d& p_W) const;
  /// d p / d x of a point fixed in `frame` and at `p_W` now: [3 x n_parameters]. Frame n_joints + 1 is the tip.
  [[nodiscard]] Eigen::Matrix3Xd point_jacobian_x(const Posture& posture, int frame, const Eigen::Vector3d& p_W) const;

  /// Geometric Jacobian of the tip in q [6 x n_joints]: linear velocity above, angular velocity below, world frame.
  [[nodiscard]] Eigen::Matrix<double, 6, Eigen::Dynamic> tip_jacobian_q(const Posture& posture) const;
  /// The same in x [6 x n_parameters]: lengths do not turn the tip, angular parameters do.
  [[nodiscard]] Eigen::Matrix<double, 6, Eigen::Dynamic> tip_jacobian_x(const Posture& posture) const;
  /// Hessian of y . (tip position) in (x, q) [n_x + n_q square], symmetric; zero between lengths (affine).
  [[nodiscard]] Eigen::MatrixXd tip_hessian(const Posture& posture, const Eigen::Vector3d& y) const;
  /// The same for the origin of a frame P that moves with `frame` and is placed there by parameters.
  [[nodiscard]] Eigen::MatrixXd point_hessian(const Posture& posture, int frame, const ParametricPose& X_FP,
                                              const Eigen::Vector3d& y) const;

  /// No posture puts the tip farther than this from the axis origin of the first joint (the base, without joints) [m].
  [[nodiscard]] double reach() const;

 private:
  /// Throws std::invalid_argument for parameters that are not the chain's, or not finite.
  void take(const Eigen::VectorXd& x);
  /// Works out what depends on the parameters; `all`: and what does not.
  void fill(bool all);

  const Chain* chain_;
  Eigen::VectorXd x_;
  std::vector<Eigen::Isometry3d> segments_;  // [n_joints + 1]
  std::vector<char> segment_rotates_;        // [n_joints + 1]; many do not: links, and hinges in a row
  std::vector<char> segment_varies_;         // [n_joints + 1], with the parameters
  std::vector<ArmGeometry> geometries_;
  std::vector<char> geometry_varies_;  // [n_geometries]; most do not: housings of drives, flanges
};

}  // namespace modsearch
