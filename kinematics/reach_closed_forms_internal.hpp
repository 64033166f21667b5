#pragma once

// Internal: arms whose nearest postures need no search. Every arm of the `seed` library with at most three joints is
// one of these, once coaxial joints are merged.

#include <modsearch/kinematics/exact_reach_internal.hpp>
#include <optional>

namespace modsearch::internal {

struct ClosedForm {
  /// Global minima, at least one; every one if `complete` (false near a point where they are not isolated).
  NearestList minima;
  bool complete = true;
  /// The minima are one family, which moves this joint through its whole turn; -1: they are isolated.
  int family_joint = -1;
};

/// The global minima where a closed form is known: two or three full-circle revolute joints,
/// - two, the second axis parallel to or meeting the first: an arc of a circle about the first axis's point;
/// - two, the second circle in a plane through the first axis: a circle in the meridional plane;
/// - three, the first two axes meeting at right angles, tip in the plane through that point: a spherical shell;
/// - three, the same but the tip at a fixed distance from that point: a sphere, in a one-parameter family of postures.
/// Nothing where the structure is another one. Minima within `tie` [m] of the least are given, that one first.
[[nodiscard]] std::optional<ClosedForm> closed_form(const ReachProblem& problem, double tie);

}  // namespace modsearch::internal
