#pragma once

#include <checker/model.hpp>

namespace modsearch_check {

/// The score and mass of a design that was checked.
struct Incumbent {
  Interval score;
  Interval mass;
};

/// Checks that a design is achieved up to the level `posture`: parameters and joints within their limits, the tip
/// within every goal, and every body apart from every obstacle, all within the slack. Throws Malformed and Rejected.
[[nodiscard]] Incumbent check_incumbent(const Problem& problem, const Value& value);

}  // namespace modsearch_check
