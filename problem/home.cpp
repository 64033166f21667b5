#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/low_discrepancy.hpp>
#include <modsearch/kinematics/space_time.hpp>
#include <modsearch/problem/task.hpp>
#include <numbers>

namespace modsearch {
namespace {

constexpr int kTries = 256;  // postures that are looked at; arbitrary: where one in fifty is free, all fail in 1 of 170

bool touches_nothing(const Arm& arm, const Scene& scene, const Eigen::VectorXd& q) {
  Work work;
  const Posture posture = arm.forward(q);
  return !scene.collides(arm, posture, work) && !self_collides(arm, posture, work) &&
         (!scene.any_moves() || clearance_at(arm, posture, scene, 0.0, work, 0.0) >= 0.0);
}

// Where a joint is looked for: within its limits, and where these are wider, one turn or two metres about 0.
Eigen::VectorXd spread_out(const Chain& chain, const Eigen::VectorXd& u) {
  Eigen::VectorXd q(chain.n_joints());
  for (int j = 0; j < chain.n_joints(); ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    const double most = joint.rotates() ? std::numbers::pi : 1.0;
    const double lower = std::max(joint.lower, std::min(-most, joint.upper));
    const double upper = std::min(joint.upper, std::max(most, joint.lower));
    q[j] = lower + u[j] * (upper - lower);
  }
  return chain.clamped(q);
}

}  // namespace

Eigen::VectorXd home_posture(const Task& task, const Arm& arm, const Scene& scene) {
  const Chain& chain = arm.chain();
  Eigen::VectorXd q = Eigen::VectorXd::Zero(chain.n_joints());
  const Eigen::VectorXd home = task.home();
  const Eigen::Index n = std::min(home.size(), q.size());
  q.head(n) = home.head(n);
  q = chain.clamped(q);
  if (home.size() > 0 || touches_nothing(arm, scene, q)) return q;
  for (int i = 0; i < kTries && chain.n_joints() > 0; ++i) {
    const Eigen::VectorXd other = spread_out(chain, halton(i, chain.n_joints()));
    if (touches_nothing(arm, scene, other)) return other;
  }
  return q;
}

}  // namespace modsearch
