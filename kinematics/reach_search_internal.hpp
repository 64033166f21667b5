#pragma once

// Internal: the two halves of the search for postures of least distance, a grid and Newton's method.

#include <modsearch/kinematics/exact_reach_internal.hpp>

namespace modsearch::internal {

/// Local minima of the distance on a regular grid over joint 1 (and joint 2); joint 0 is eliminated in closed form, as
/// if it had no limits. `q`: with joint 0 within them; `distance`: without.
[[nodiscard]] NearestList grid_minima_2(const ReachProblem& problem);
[[nodiscard]] NearestList grid_minima_3(const ReachProblem& problem);

/// Distance between neighbouring grid points of joint `j` [rad or m].
[[nodiscard]] double grid_step(const ReachProblem& problem, int j);

/// `q` taken into the limits, with joint 0 where it brings the tip closest.
[[nodiscard]] ReachJoints with_best_first_joint(const ReachProblem& problem, const ReachJoints& q);

/// What Newton's method ended at.
struct Descent {
  Nearest end;
  /// Least eigenvalue of the Hessian of half the squared distance, over the joints that are free to move (not pressed
  /// against a limit), divided by the largest; and its direction, greatest component 1. About 0: the posture may belong
  /// to a family; small: another minimum may be close by; below 0: a saddle.
  double flatness = 1.0;
  ReachJoints flat_direction = ReachJoints::Zero();
};

/// Projected Newton's method with the exact Hessian on half the squared distance, from `q`. Two or three joints.
[[nodiscard]] Descent descend(const ReachProblem& problem, const ReachJoints& q, ReachWork& work);

}  // namespace modsearch::internal
