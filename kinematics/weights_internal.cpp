#include <modsearch/kinematics/weights_internal.hpp>

namespace modsearch::detail {

Weights::Weights(const Chain& chain) {
  for (const Body& body : chain.bodies()) {
    if (body.frame == 0) continue;  // rests on the ground
    HungBody hung{.body = &body,
                  .X_FM = body.spread.X_FB * AffinePose{Eigen::Matrix3d::Identity(), body.spread.r_com},
                  .varies = false};
    const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(chain.n_parameters());
    hung.X_FM.for_each_move(nothing, [&](const ParameterMove&) { hung.varies = true; });
    hung.varies = hung.varies || !body.mass.terms.empty();
    hung.mass = body.mass.at(nothing);
    hung.p_FM = hung.X_FM.at(nothing).translation();
    bodies_.push_back(std::move(hung));
  }
  mass_.resize(static_cast<std::size_t>(chain.n_joints()) + 2);
  moment_.resize(mass_.size());
}

void Weights::set_parameters(const Eigen::VectorXd& x) {
  for (HungBody& hung : bodies_) {
    if (!hung.varies) continue;
    hung.mass = hung.body->mass.at(x);
    hung.p_FM = hung.X_FM.at(x).translation();
    hung.moves.clear();
    hung.X_FM.for_each_move(x, [&](const ParameterMove& move) { hung.moves.push_back(move); });
  }
}

void Weights::hang(const Posture& posture, const ArmMoves& order, const std::vector<Move>& moves,
                   const StaticLoad& load) {
  posture_ = &posture;
  order_ = &order;
  moves_ = &moves;
  load_ = load;
  std::size_t frame = mass_.size() - 1;
  mass_[frame] = load.payload;
  moment_[frame] = load.payload * posture.tip.translation();
  auto body = bodies_.rbegin();
  while (frame-- > 0) {
    mass_[frame] = mass_[frame + 1];
    moment_[frame] = moment_[frame + 1];
    for (; body != bodies_.rend() && static_cast<std::size_t>(body->body->frame) == frame; ++body) {
      body->p_WM = posture.frames[frame] * body->p_FM;
      mass_[frame] += body->mass;
      moment_[frame] += body->mass * body->p_WM;
    }
  }
  rate_.resize(moves.size());
  std::size_t k = 0;
  for (frame = 1; frame < mass_.size(); ++frame) {
    for (; k < order.count(static_cast<int>(frame)); ++k) {
      const Move& move = moves[k];
      rate_[k] = move.turns ? move.direction.cross(moment_[frame] - mass_[frame] * move.point).eval()
                            : (mass_[frame] * move.direction).eval();
    }
  }
}

double Weights::torque(int joint) const {
  const std::size_t at = order_->of_joint(joint);
  const Move& own = (*moves_)[at];
  double torque = -load_.gravity.dot(rate_[at]) - load_.wrench.force.dot(own.velocity(posture_->tip.translation()));
  if (own.turns) torque -= own.direction.dot(load_.wrench.torque);
  return torque;
}

}  // namespace modsearch::detail
