#include <modsearch/kinematics/arm_moves_internal.hpp>

namespace modsearch::detail {

ArmMoves::ArmMoves(const Chain& chain)
    : chain_{chain}, in_segment_(static_cast<std::size_t>(chain.n_joints()) + 1), counts_{0} {
  set_parameters(Eigen::VectorXd::Zero(chain.n_parameters()));  // how many moves there are does not depend on them
  for (const std::vector<ParameterMove>& moves : in_segment_) counts_.push_back(counts_.back() + moves.size() + 1);
  --counts_.back();  // no joint behind the last segment
}

void ArmMoves::set_parameters(const Eigen::VectorXd& x) {
  for (std::size_t j = 0; j < in_segment_.size(); ++j) {
    in_segment_[j].clear();
    chain_.segment(static_cast<int>(j)).for_each_move(x, [&](const ParameterMove& move) {
      in_segment_[j].push_back(move);
    });
  }
}

void ArmMoves::place(const Posture& posture, std::vector<Move>& moves) const {
  moves.resize(counts_.back());
  auto next = moves.begin();
  for (std::size_t j = 0; j < in_segment_.size(); ++j) {
    const Eigen::Isometry3d& X_WF = posture.frames[j];
    for (const ParameterMove& move : in_segment_[j]) {
      *next++ = {move.parameter, move.turns, X_WF.linear() * move.direction, X_WF * move.point};
    }
    if (j + 1 == in_segment_.size()) break;
    const int joint = static_cast<int>(j);
    *next++ = {chain_.n_parameters() + joint, chain_.joints()[j].rotates(), posture.axis(joint), posture.origin(joint)};
  }
}

}  // namespace modsearch::detail
