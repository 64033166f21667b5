#pragma once

#include <modsearch/kinematics/arm.hpp>

namespace modsearch {

/// How far points of an arm's bodies move at most when its joints do [m]: |dq_j| times the lever of joint j, summed.
///
/// The lever of a joint that turns is the largest distance that any point of the body can have from its axis, over all
/// joint values of a box; of one that slides it is 1. A point's velocity is the sum over the joints of axis x arm (or
/// the axis), so the sum bounds the way of every point along a straight line in joint space within the box.
class MotionBound {
 public:
  /// `lower`, `upper` [n_joints]: the box, finite where a joint slides; turning joints may turn anywhere.
  MotionBound(const Arm& arm, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper);

  /// Lever of joint `joint` for geometry `geometry` of the arm [m] or [1]; 0 for joints that do not move it.
  [[nodiscard]] double lever(std::size_t geometry, int joint) const {
    return levers_(joint, static_cast<Eigen::Index>(geometry));
  }
  /// No point of any body moves farther than this along the straight line from `a` to `b` [n_joints] [m].
  [[nodiscard]] double travel(const double* a, const double* b) const;

 private:
  Eigen::MatrixXd levers_;  // [n_joints x n_geometries]
};

}  // namespace modsearch
