#pragma once

#include <modsearch/kinematics/inverse_kinematics.hpp>
#include <span>

namespace modsearch {

/// Seconds that the slowest joint takes from one posture to another [n_joints]; a joint whose velocity is not limited
/// moves at 1 rad/s or 1 m/s.
[[nodiscard]] double travel_time(const Chain& chain, const Eigen::VectorXd& from, const Eigen::VectorXd& to);

/// The posture that a local search finds from `q`: the nearest one, on the same branch, for a region close by. `q`
/// itself where it is within the region already. Throws std::invalid_argument if q.size() != n_joints.
[[nodiscard]] IkSolution nearby_posture(const Arm& arm, const PoseRegion& region, const Eigen::VectorXd& q,
                                        int iterations = 64);

struct FollowOptions {
  int iterations = 64;  ///< of the local search for one pose at most
  /// No joint moves farther between neighbouring poses [rad] or [m]: a larger step is a jump to another branch. Ample
  /// for poses a few centimetres apart, except close to a singular posture (arbitrary).
  double largest_step = 0.3;
};

/// Why a trajectory was not followed to its end.
enum class FollowEnd { kDone, kUnreachable, kJump, kTooFast };

struct Following {
  FollowEnd end = FollowEnd::kDone;
  std::size_t n_followed = 0;   ///< poses before it ended
  double position_error = 0.0;  ///< largest distance from a nominal position, the pose where it ended included [m]
  Eigen::MatrixXd postures;     ///< [n_poses x n_joints]; behind the end: the last posture again
  std::int64_t iterations = 0, forward = 0;
};

/// Follows `poses` from the posture `q` that fulfils the first: each posture is the local search's from the one before,
/// so that the arm stays on its branch. `times` [n_poses] s, or empty: with them no joint may be faster than its
/// velocity limit on the way from one to the next.
[[nodiscard]] Following follow_poses(const Arm& arm, std::span<const PoseRegion> poses, std::span<const double> times,
                                     const Eigen::VectorXd& q, const FollowOptions& options = {});

}  // namespace modsearch
