#pragma once

#include <modsearch/kinematics/motion_bound_internal.hpp>
#include <modsearch/kinematics/scene.hpp>
#include <vector>

namespace modsearch {

/// Number of equal parts, at least 1, that an edge with the given travel is cut into: none is longer than `resolution`.
[[nodiscard]] std::int64_t parts_of(double travel, double resolution);
/// State k of the edge from `a` to `b` [n_joints] in n parts, 0 <= k <= n. The same to the last bit seen from either
/// end.
void interpolate(const double* a, const double* b, std::int64_t k, std::int64_t n, int n_joints, double* q);

/// What planning asks about the world.
class MotionChecker {
 public:
  virtual ~MotionChecker() = default;
  /// No overlap at `q` [n_joints].
  [[nodiscard]] virtual bool state_free(const double* q) = 0;
  /// No overlap at any state of the edge from `a` to `b` but `a` itself, which the caller knows to be free.
  [[nodiscard]] virtual bool edge_free(const double* a, const double* b) = 0;
};

/// Tells whether an arm can move along a straight line in joint space, by looking at so many states of it that no body
/// point moves farther than `resolution` from one to the next.
///
/// States that a neighbour's clearance proves free are not looked at: a body whose clearance at one state is d stays
/// free for as long as the motion bound stays below d. The verdict is that of looking at every state. The states of an
/// edge are the same from either end, to the last bit, and so is the verdict.
///
/// Keeps scratch space: one checker per thread. `arm` and `scene` must outlive it.
class EdgeChecker final : public MotionChecker {
 public:
  /// `lower`, `upper` [n_joints]: the joint box that all edges lie in, see MotionBound. `resolution` > 0 [m].
  EdgeChecker(const Arm& arm, const Scene& scene, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
              double resolution, bool self_collision);

  [[nodiscard]] bool state_free(const double* q) override;
  [[nodiscard]] bool edge_free(const double* a, const double* b) override;

  [[nodiscard]] const Work& work() const { return work_; }

 private:
  struct Range {
    std::int64_t first;
    std::int64_t last;
  };
  void measure_edge(const double* a, const double* b);
  [[nodiscard]] double free_part(const double* q);
  [[nodiscard]] bool part_free_of_obstacles(double& part);
  [[nodiscard]] bool part_free_of_self(double& part);

  const Arm& arm_;
  const Scene& scene_;
  MotionBound motion_;
  double resolution_;
  bool self_collision_;
  Work work_;

  Posture posture_;
  std::vector<Eigen::Isometry3d> poses_;   // X_WG [n_geometries] at the state looked at
  std::vector<BoundingCapsule> capsules_;  // about them
  Eigen::MatrixXd travel_;                 // [n_joints + 1 x n_geometries]: row j: way by joints j, j + 1, ...
  Eigen::VectorXd q_;
  std::vector<Range> ranges_;  // states still to look at
};

}  // namespace modsearch
