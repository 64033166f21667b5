#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/bounding_capsule.hpp>
#include <modsearch/kinematics/motion_bound_internal.hpp>

namespace modsearch {
namespace {

double from_origin(const Eigen::Vector3d& p) { return p.norm(); }
double from_axis(const Eigen::Vector3d& p) { return std::hypot(p.x(), p.y()); }

// Largest `distance` (a convex function) of any point of the geometry, from the origin or the z axis of its frame F.
template <typename Distance>
double farthest(const ArmGeometry& geometry, Distance distance) {
  const BoundingCapsule capsule = bounding_capsule(geometry.shape, geometry.bounding_radius, geometry.X_FG);
  const double by_capsule = capsule.radius + std::max(distance(capsule.centre_W + capsule.half_axis_W),
                                                      distance(capsule.centre_W - capsule.half_axis_W));
  return std::min(by_capsule, distance(geometry.X_FG.translation()) + geometry.bounding_radius);
}

}  // namespace

MotionBound::MotionBound(const Arm& arm, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) {
  const std::vector<Joint>& joints = arm.chain().joints();
  const auto n_geometries = static_cast<Eigen::Index>(arm.geometries().size());
  levers_ = Eigen::MatrixXd::Zero(arm.n_joints(), n_geometries);

  // Largest distance of the origin of frame i + 1, seen from frame i: joint i may have slid either way.
  const auto stride = [&](int i, auto distance) {
    const Eigen::Isometry3d& segment = arm.segment(i);
    if (joints[static_cast<std::size_t>(i)].rotates()) return distance(segment.translation());
    const Eigen::Vector3d axis = segment.linear().col(2);
    return std::max(distance(segment.translation() + lower[i] * axis),
                    distance(segment.translation() + upper[i] * axis));
  };

  for (Eigen::Index g = 0; g < n_geometries; ++g) {
    const ArmGeometry& geometry = arm.geometries()[static_cast<std::size_t>(g)];
    double beyond = farthest(geometry, from_origin);  // from the origin of frame j + 2 on, any direction
    for (int j = geometry.frame - 1; j >= 0; --j) {
      const bool last = j == geometry.frame - 1;
      if (j + 2 < geometry.frame) beyond += stride(j + 2, from_origin);
      if (!joints[static_cast<std::size_t>(j)].rotates()) {
        levers_(j, g) = 1.0;
      } else if (last) {
        levers_(j, g) = farthest(geometry, from_axis);
      } else {
        // The first stride is fixed in the frame that joint j turns: what lies along its axis is no lever.
        levers_(j, g) = stride(j + 1, from_axis) + beyond;
      }
    }
  }
}

double MotionBound::travel(const double* a, const double* b) const {
  double most = 0.0;
  for (Eigen::Index g = 0; g < levers_.cols(); ++g) {
    double sum = 0.0;
    for (Eigen::Index j = 0; j < levers_.rows(); ++j) sum += std::abs(b[j] - a[j]) * levers_(j, g);
    most = std::max(most, sum);
  }
  return most;
}

}  // namespace modsearch
