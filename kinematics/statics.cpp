#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/weights_internal.hpp>

namespace modsearch {

Eigen::VectorXd static_torques(const Arm& arm, const Posture& posture, const StaticLoad& load) {
  const int n = arm.n_joints();
  const Eigen::Vector3d& p_WE = posture.tip.translation();
  // Mass and first moment of everything beyond a joint, from the tip inwards; forces on the tip apart.
  double mass = load.payload;
  Eigen::Vector3d moment = load.payload * p_WE;
  Eigen::VectorXd torques(n);
  auto body = arm.chain().bodies().rbegin();
  for (int j = n - 1; j >= 0; --j) {
    const Eigen::Isometry3d& X_WF = posture.frames[static_cast<std::size_t>(j) + 1];
    for (; body != arm.chain().bodies().rend() && body->frame == j + 1; ++body) {
      const double its_mass = body->mass.at(arm.parameters());
      const Eigen::Vector3d p_FM = body->spread.X_FB.at(arm.parameters()) * body->spread.r_com.at(arm.parameters());
      mass += its_mass;
      moment += its_mass * (X_WF * p_FM);
    }
    const Eigen::Vector3d axis = posture.axis(j);
    if (arm.chain().joints()[static_cast<std::size_t>(j)].rotates()) {
      const Eigen::Vector3d point = posture.origin(j);
      torques[j] = -load.gravity.dot(axis.cross(moment - mass * point)) -
                   load.wrench.force.dot(axis.cross(p_WE - point)) - load.wrench.torque.dot(axis);
    } else {
      torques[j] = -mass * load.gravity.dot(axis) - load.wrench.force.dot(axis);
    }
  }
  return torques;
}

Eigen::MatrixXd static_torque_jacobian(const Arm& arm, const Posture& posture, const StaticLoad& load) {
  detail::ArmMoves order{arm.chain()};
  order.set_parameters(arm.parameters());
  std::vector<detail::Move> moves;
  order.place(posture, moves);
  detail::Weights weights{arm.chain()};
  weights.set_parameters(arm.parameters());
  weights.hang(posture, order, moves, load);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(arm.n_joints(), arm.chain().n_parameters() + arm.n_joints());
  for (int j = 0; j < arm.n_joints(); ++j) {
    weights.for_each_slope(j, [&](int variable, double slope) { J(j, variable) += slope; });
  }
  return J;
}

double torque_share(const Chain& chain, const Eigen::VectorXd& torques) {
  double share = 0.0;
  for (int j = 0; j < chain.n_joints(); ++j) {
    const double peak = chain.joints()[static_cast<std::size_t>(j)].peak_torque;
    if (std::isfinite(peak) && torques[j] != 0.0) share = std::max(share, std::abs(torques[j]) / peak);
  }
  return share;
}

}  // namespace modsearch
