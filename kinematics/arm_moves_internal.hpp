#pragma once

#include <modsearch/kinematics/arm.hpp>
#include <span>
#include <vector>

namespace modsearch::detail {

/// Something that moves the outer part of an arm at one posture: a joint, or a parameter at one place of the chain.
/// World axes.
struct Move {
  int variable = 0;           ///< i: parameter i; n_parameters + j: joint j
  bool turns = false;         ///< or slides
  Eigen::Vector3d direction;  ///< of the slide [m per unit], or the axis, as long as the angle grows [rad per unit]
  Eigen::Vector3d point;      ///< on the axis [m]

  /// d p_W / d variable of a point beyond, which is at `p_W` now.
  [[nodiscard]] Eigen::Vector3d velocity(const Eigen::Vector3d& p_W) const {
    return turns ? direction.cross(p_W - point).eval() : direction;
  }
};

/// Everything that moves an arm, from the base outwards: first what the parameters do in segment 0 of the chain, then
/// joint 0, segment 1, and so on. What an earlier move turns, it turns with all later ones, from which all derivatives
/// of a chain follow (Featherstone, Rigid Body Dynamics Algorithms, 2008, section 4.6; DOI
/// 10.1007/978-1-4899-7560-7): for a point p beyond moves a and b, a no later than b and a turn,
/// d^2 p / d a d b = axis_a x velocity_b(p).
///
/// Allocates when it is made and when a list of moves is filled for the first time.
class ArmMoves {
 public:
  /// `chain` must outlive it.
  explicit ArmMoves(const Chain& chain);

  /// Takes other parameters [n_parameters]: the moves of twisted segments depend on them.
  void set_parameters(const Eigen::VectorXd& x);
  /// The moves at `posture`, into a list that is used again and again.
  void place(const Posture& posture, std::vector<Move>& moves) const;

  /// How many of the moves, from the first on, move what is fixed in `frame`; frame n_joints + 1 is the tip.
  [[nodiscard]] std::size_t count(int frame) const { return counts_[static_cast<std::size_t>(frame)]; }
  /// The place of joint `j` among the moves.
  [[nodiscard]] std::size_t of_joint(int j) const { return count(j + 1) - 1; }

 private:
  const Chain& chain_;
  std::vector<std::vector<ParameterMove>> in_segment_;  // [n_joints + 1], in the frame before the segment
  std::vector<std::size_t> counts_;                     // [n_joints + 2]
};

}  // namespace modsearch::detail
