#pragma once

#include <modsearch/kinematics/arm.hpp>

namespace modsearch::detail {

/// Calls `visit(first, second)` with the indices of every two geometries that self-collision compares, in the order of
/// Chain::self_pairs, until it returns true. True: it was stopped. Allocates nothing: geometries are ordered by body,
/// and the pairs of bodies lexicographically, so that two cursors find the geometries of each.
template <typename Visit>
bool any_self_pair(const Arm& arm, Visit&& visit) {
  const std::vector<ArmGeometry>& geometries = arm.geometries();
  const std::size_t n = geometries.size();
  std::size_t first_begin = 0;
  std::size_t second_begin = 0;
  int current = -1;
  for (const auto& [first, second] : arm.chain().self_pairs()) {
    if (first != current) {
      current = first;
      while (first_begin < n && geometries[first_begin].body < first) ++first_begin;
      second_begin = first_begin;
    }
    while (second_begin < n && geometries[second_begin].body < second) ++second_begin;
    for (std::size_t a = first_begin; a < n && geometries[a].body == first; ++a) {
      for (std::size_t b = second_begin; b < n && geometries[b].body == second; ++b) {
        if (visit(a, b)) return true;
      }
    }
  }
  return false;
}

}  // namespace modsearch::detail
