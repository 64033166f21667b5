#pragma once

#include <modsearch/kinematics/arm.hpp>

namespace modsearch {

/// What acts on the tip: a force on its origin [N] and a torque [N m], world axes.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
};

/// What an arm that stands still has to bear.
struct StaticLoad {
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  ///< [m/s^2], world axes
  double payload = 0.0;                      ///< point mass at the tip [kg]
  Wrench wrench{};
};

/// Torques (joints that slide: forces) with which the joints hold the arm still against the weight of its bodies, the
/// payload and the wrench [n_joints], N m or N; along +q. The gradient of the potential energy in q.
[[nodiscard]] Eigen::VectorXd static_torques(const Arm& arm, const Posture& posture, const StaticLoad& load);

/// Their exact derivatives in the parameters and the joints [n_joints x (n_parameters + n_joints)].
[[nodiscard]] Eigen::MatrixXd static_torque_jacobian(const Arm& arm, const Posture& posture, const StaticLoad& load);

/// Largest share of a joint's peak torque that `torques` [n_joints] ask for: above 1 it cannot hold. 0 without limits.
[[nodiscard]] double torque_share(const Chain& chain, const Eigen::VectorXd& torques);

}  // namespace modsearch
