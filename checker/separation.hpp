#pragma once

#include <checker/problem.hpp>

namespace modsearch_check {

/// A shape of fixed size somewhere in the world. Box: edges; cylinder: radius, height; sphere: radius.
struct Solid {
  Kind kind = Kind::kSphere;
  std::vector<Interval> size;
  Matrix turn;
  Vector centre{};
};

/// Whether a plane shows that two solids do not overlap by more than the slack. `normals`: directions from b to a to
/// try first; then some of its own. False where none was found.
[[nodiscard]] bool are_apart(const Solid& a, const Solid& b, const std::vector<Numbers>& normals);

}  // namespace modsearch_check
