#pragma once

// Internal: every local minimum of a two- or three-joint arm's distance that can be the global one.

#include <modsearch/kinematics/exact_reach_internal.hpp>
#include <vector>

namespace modsearch::internal {

struct Minimum {
  Nearest nearest;
  /// Whether the minimum may belong to a family (the Hessian is singular), which leads on in `direction`.
  bool flat = false;
  ReachJoints direction = ReachJoints::Zero();
};

/// The minima of one joint, least distance first: the target's nearest point on an arc or a segment, in closed form.
[[nodiscard]] NearestList one_joint_minima(const ReachProblem& problem);

/// At least one minimum of two or three joints, least distance first; distinct. `all` false: only the first matters, so
/// the search ends when nothing can be closer. Joints that share an axis must have been merged.
[[nodiscard]] std::vector<Minimum> minima(const ReachProblem& problem, bool all, ReachWork& work);

}  // namespace modsearch::internal
