#include <algorithm>
#include <modsearch/kinematics/parametric_pose.hpp>

namespace modsearch {
namespace {

Eigen::Isometry3d about_z(double angle) {
  return Eigen::Isometry3d{Eigen::AngleAxisd{angle, Eigen::Vector3d::UnitZ()}};
}

AffineScalar negative(AffineScalar number) {
  number.offset = -number.offset;
  for (AffineScalar::Term& term : number.terms) term.scale = -term.scale;
  return number;
}

}  // namespace

ParametricPose ParametricPose::turn(AffineScalar angle) {
  if (angle.terms.empty()) return angle.offset == 0.0 ? ParametricPose{} : ParametricPose{about_z(angle.offset)};
  ParametricPose result;
  result.turns.push_back({std::move(angle), AffinePose{}});
  return result;
}

Eigen::Isometry3d ParametricPose::at(const Eigen::VectorXd& x) const {
  Eigen::Isometry3d X = head.at(x);
  for (const Turn& turn : turns) X = X * about_z(turn.angle.at(x)) * turn.after.at(x);
  return X;
}

ParametricPose ParametricPose::inverse() const {
  if (turns.empty()) return head.inverse();
  ParametricPose result{turns.back().after.inverse()};
  for (std::size_t i = turns.size(); i-- > 0;) {
    result.turns.push_back({negative(turns[i].angle), (i == 0 ? head : turns[i - 1].after).inverse()});
  }
  return result;
}

ParametricPose ParametricPose::shifted(int shift) const {
  ParametricPose result{head.shifted(shift)};
  for (const Turn& turn : turns) result.turns.push_back({turn.angle.shifted(shift), turn.after.shifted(shift)});
  return result;
}

ParametricPose operator*(ParametricPose X_AB, const ParametricPose& X_BC) {
  AffinePose& last = X_AB.turns.empty() ? X_AB.head : X_AB.turns.back().after;
  last = last * X_BC.head;
  X_AB.turns.insert(X_AB.turns.end(), X_BC.turns.begin(), X_BC.turns.end());
  return X_AB;
}

}  // namespace modsearch
