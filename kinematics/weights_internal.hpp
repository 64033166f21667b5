#pragma once

#include <modsearch/kinematics/arm_moves_internal.hpp>
#include <modsearch/kinematics/statics.hpp>

namespace modsearch::detail {

/// The weights that hang on an arm, and what its joints need to hold them, with exact derivatives in the parameters and
/// the joints: linear in the number of bodies for all torques, and a product of vectors for every derivative.
///
/// Whatever hangs beyond a move acts on it as one mass M with first moment S = sum m c. The torque of joint j is the
/// slope of the potential energy, -g . P_j, with P = sum m (velocity of c) = M v or axis x (S - M point); a move a
/// before a move b, and a turn, changes the slope in b by -g . (axis_a x P_b), which is symmetric. Masses that depend
/// on parameters, and centres of mass that parameters shift within a body, are added body by body.
class Weights {
 public:
  /// `chain` must outlive it.
  explicit Weights(const Chain& chain);

  void set_parameters(const Eigen::VectorXd& x);
  /// Hangs everything on the arm at `posture`. `moves`: those of the arm there, which must stay until the next call.
  void hang(const Posture& posture, const ArmMoves& order, const std::vector<Move>& moves, const StaticLoad& load);

  /// See static_torques.
  [[nodiscard]] double torque(int joint) const;
  /// Calls `add(variable, slope)` for the parts of the torque's derivatives; variables as in Move. A variable may come
  /// more than once.
  template <typename Add>
  void for_each_slope(int joint, Add&& add) const;

 private:
  struct HungBody {
    const Body* body;
    ParametricPose X_FM;  // its origin is the centre of mass
    bool varies;          // with the parameters
    double mass = 0.0;
    Eigen::Vector3d p_FM = Eigen::Vector3d::Zero();
    Eigen::Vector3d p_WM = Eigen::Vector3d::Zero();
    std::vector<ParameterMove> moves{};  // of the centre of mass, in frame F
  };

  std::vector<HungBody> bodies_;         // those that move, from the base outwards
  std::vector<double> mass_;             // [n_joints + 2] of what is fixed in a frame or beyond it
  std::vector<Eigen::Vector3d> moment_;  // of the same: sum of m c
  std::vector<Eigen::Vector3d> rate_;    // P of every move
  // What `hang` was given.
  const Posture* posture_ = nullptr;
  const ArmMoves* order_ = nullptr;
  const std::vector<Move>* moves_ = nullptr;
  StaticLoad load_;
};

template <typename Add>
void Weights::for_each_slope(int joint, Add&& add) const {
  const std::size_t at = order_->of_joint(joint);
  const Move& own = (*moves_)[at];
  const Eigen::Vector3d& p_WE = posture_->tip.translation();
  const bool pulled = !load_.wrench.force.isZero(0.0);
  const bool twisted = own.turns && !load_.wrench.torque.isZero(0.0);
  const Eigen::Vector3d velocity = pulled ? own.velocity(p_WE) : Eigen::Vector3d::Zero().eval();
  for (std::size_t k = 0; k <= at; ++k) {
    const Move& earlier = (*moves_)[k];
    if (!earlier.turns) continue;
    double slope = -load_.gravity.cross(earlier.direction).dot(rate_[at]);
    if (pulled) slope -= load_.wrench.force.cross(earlier.direction).dot(velocity);
    if (twisted) slope -= earlier.direction.cross(own.direction).dot(load_.wrench.torque);
    add(earlier.variable, slope);
  }
  if (own.turns) {
    const Eigen::Vector3d lever = load_.gravity.cross(own.direction);
    const Eigen::Vector3d pull = load_.wrench.force.cross(own.direction);
    for (std::size_t k = at + 1; k < moves_->size(); ++k) {
      const Move& later = (*moves_)[k];
      add(later.variable, -lever.dot(rate_[k]) - (pulled ? pull.dot(later.velocity(p_WE)) : 0.0));
    }
  }
  for (auto body = bodies_.rbegin(); body != bodies_.rend() && body->body->frame > joint; ++body) {
    if (!body->varies) continue;
    const double per_kilogram = -load_.gravity.dot(own.velocity(body->p_WM));
    for (const AffineScalar::Term& term : body->body->mass.terms) add(term.parameter, term.scale * per_kilogram);
    if (!own.turns) continue;
    const Eigen::Vector3d lever = body->mass * load_.gravity.cross(own.direction);
    const Eigen::Isometry3d& X_WF = posture_->frames[static_cast<std::size_t>(body->body->frame)];
    for (const ParameterMove& move : body->moves) add(move.parameter, -lever.dot(move.velocity(X_WF, body->p_WM)));
  }
}

}  // namespace modsearch::detail
