#pragma once

#include <checker/tree.hpp>

namespace modsearch_check {

/// Checks that every sequence of module types that a design may have is dealt with: for n = 0, 1, .. modules behind the
/// base, either no n modules are light enough to score more than `upper`, or each fitting sequence has a tree in
/// `sequences` (in the order of n, then of the types in the library) or falls to the reach test. Throws Malformed and
/// Rejected.
[[nodiscard]] Count check_sequences(const Problem& problem, const Value& sequences, double upper);

}  // namespace modsearch_check
