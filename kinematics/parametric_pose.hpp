#pragma once

#include <modsearch/kinematics/affine.hpp>

namespace modsearch {

/// One way in which a parameter moves what lies beyond a pose: it slides it, or turns it about an axis.
struct ParameterMove {
  int parameter = 0;
  bool turns = false;
  Eigen::Vector3d direction;  ///< [m per unit], or the axis, as long as the angle grows [rad per unit]
  Eigen::Vector3d point;      ///< on the axis [m]

  /// d p_W / d parameter of a point beyond, which is at `p_W` now; `X_WF`: the frame that the pose is given in.
  [[nodiscard]] Eigen::Vector3d velocity(const Eigen::Isometry3d& X_WF, const Eigen::Vector3d& p_W) const {
    if (!turns) return X_WF.linear() * direction;
    return (X_WF.linear() * direction).cross(p_W - X_WF * point);
  }
};

/// A pose that depends on parameters: affine poses with turns about z between them, whose angles are parameters (the
/// twist of a link). Without turns it is affine; with the angles held it is affine in the lengths.
struct ParametricPose {
  /// Rz(angle), and what follows it.
  struct Turn {
    AffineScalar angle;  ///< [rad]
    AffinePose after;
  };
  AffinePose head;
  std::vector<Turn> turns;

  ParametricPose() = default;
  ParametricPose(AffinePose X) : head{std::move(X)} {}     // NOLINT: an affine pose is a parametric one
  ParametricPose(const Eigen::Isometry3d& X) : head{X} {}  // NOLINT: and so is a constant one
  /// Rz(angle). A constant angle leaves no turn behind.
  [[nodiscard]] static ParametricPose turn(AffineScalar angle);

  /// The rotation is constant and the translation affine in the parameters.
  [[nodiscard]] bool affine() const { return turns.empty(); }
  [[nodiscard]] Eigen::Isometry3d at(const Eigen::VectorXd& x) const;
  [[nodiscard]] ParametricPose inverse() const;
  /// Every parameter index raised by `shift`.
  [[nodiscard]] ParametricPose shifted(int shift) const;

  /// Calls `visit(move)` for every ParameterMove at `x`, from the frame of the pose outwards.
  template <typename Visit>
  void for_each_move(const Eigen::VectorXd& x, Visit&& visit) const;
};
/// X_AC = X_AB * X_BC.
[[nodiscard]] ParametricPose operator*(ParametricPose X_AB, const ParametricPose& X_BC);

template <typename Visit>
void ParametricPose::for_each_move(const Eigen::VectorXd& x, Visit&& visit) const {
  const auto slide = [&](const AffineVector::Term& term, const Eigen::Vector3d& direction) {
    visit(ParameterMove{term.parameter, false, direction, Eigen::Vector3d::Zero()});
  };
  for (const AffineVector::Term& term : head.translation.terms) slide(term, term.direction);
  if (turns.empty()) return;
  Eigen::Isometry3d X = head.at(x);
  for (const Turn& turn : turns) {
    for (const AffineScalar::Term& term : turn.angle.terms) {
      visit(ParameterMove{term.parameter, true, term.scale * X.linear().col(2), X.translation()});
    }
    X.rotate(Eigen::AngleAxisd{turn.angle.at(x), Eigen::Vector3d::UnitZ()});
    for (const AffineVector::Term& term : turn.after.translation.terms) slide(term, X.linear() * term.direction);
    X = X * turn.after.at(x);
  }
}

}  // namespace modsearch
