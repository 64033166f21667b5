#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/statics.hpp>

namespace modsearch {
namespace {

// The centre of mass in the frame that the body moves with, as the origin of a frame.
ParametricPose centre_of_mass(const Body& body) {
  return body.spread.X_FB * AffinePose{Eigen::Matrix3d::Identity(), body.spread.r_com};
}

}  // namespace

Eigen::VectorXd static_torques(const Arm& arm, const Posture& posture, const StaticLoad& load) {
  Eigen::VectorXd torques = Eigen::VectorXd::Zero(arm.n_joints());
  const auto hang = [&](int frame, const Eigen::Vector3d& p_W, const Eigen::Vector3d& force) {
    torques -= arm.point_jacobian_q(posture, frame, p_W).transpose() * force;
  };
  for (const Body& body : arm.chain().bodies()) {
    if (body.frame == 0) continue;  // rests on the ground
    const double mass = body.mass.at(arm.parameters());
    const Eigen::Vector3d p_FM = centre_of_mass(body).at(arm.parameters()).translation();
    hang(body.frame, posture.frames[static_cast<std::size_t>(body.frame)] * p_FM, mass * load.gravity);
  }
  hang(arm.n_joints(), posture.tip.translation(), load.payload * load.gravity + load.wrench.force);
  torques -= arm.tip_jacobian_q(posture).bottomRows<3>().transpose() * load.wrench.torque;
  return torques;
}

Eigen::MatrixXd static_torque_jacobian(const Arm& arm, const Posture& posture, const StaticLoad& load) {
  const int n_x = arm.chain().n_parameters();
  const int n_q = arm.n_joints();
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n_q, n_x + n_q);
  for (const Body& body : arm.chain().bodies()) {
    if (body.frame == 0) continue;
    const double mass = body.mass.at(arm.parameters());
    const ParametricPose X_FM = centre_of_mass(body);
    J -= arm.point_hessian(posture, body.frame, X_FM, mass * load.gravity).bottomRows(n_q);
    if (body.mass.terms.empty()) continue;
    const Eigen::Vector3d p_FM = X_FM.at(arm.parameters()).translation();
    const Eigen::Vector3d p_WM = posture.frames[static_cast<std::size_t>(body.frame)] * p_FM;
    const Eigen::VectorXd per_kilogram = -arm.point_jacobian_q(posture, body.frame, p_WM).transpose() * load.gravity;
    for (const AffineScalar::Term& term : body.mass.terms) J.col(term.parameter) += term.scale * per_kilogram;
  }
  J -= arm.tip_hessian(posture, load.payload * load.gravity + load.wrench.force).bottomRows(n_q);
  if (load.wrench.torque.isZero(0.0)) return J;

  // Axis j turns with every joint and every angular parameter before it: d (axis_j . T) = (w x axis_j) . T.
  for (int j = 0; j < n_q; ++j) {
    if (!arm.chain().joints()[static_cast<std::size_t>(j)].rotates()) continue;
    const Eigen::Vector3d lever = posture.axis(j).cross(load.wrench.torque);  // (w x a) . T = w . (a x T)
    for (int i = 0; i < j; ++i) {
      if (arm.chain().joints()[static_cast<std::size_t>(i)].rotates()) J(j, n_x + i) -= posture.axis(i).dot(lever);
    }
    for (int i = 0; i <= j; ++i) {
      const Eigen::Isometry3d& X_WF = posture.frames[static_cast<std::size_t>(i)];
      arm.chain().segment(i).for_each_move(arm.parameters(), [&](const ParameterMove& move) {
        if (move.turns) J(j, move.parameter) -= (X_WF.linear() * move.direction).dot(lever);
      });
    }
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
