#pragma once

#include <modsearch/problem/module_library.hpp>
#include <vector>

namespace modsearch {

/// How many type sequences there are. Exact up to 2^53, rounded beyond.
struct SequenceCount {
  double all = 0.0;       ///< whatever their connectors: as many as there were if everything fitted everything
  double fitting = 0.0;   ///< of these, those whose connectors fit, one after the other
  double complete = 0.0;  ///< of these, those that lack nothing: see ModuleLibrary::complete
};

/// Between `least` and `most` modules of one role in a row.
struct PatternPart {
  ModuleRole role = ModuleRole::kLink;
  int least = 1;
  int most = 1;
};

/// Counts the type sequences of `n` modules (the base not counted) without building one: dynamic programming over the
/// free end, because what may follow depends on nothing else. O(n * n_types^2).
/// Throws std::invalid_argument if n < 0.
[[nodiscard]] SequenceCount count_sequences(const ModuleLibrary& library, int n);

/// Counts designs instead where type k stands for `weights[k]` of them, and only those that begin with `prefix`.
/// Throws std::invalid_argument if n is less than the prefix has, there is not one weight per type, or the prefix does
/// not fit together.
[[nodiscard]] SequenceCount count_designs(const ModuleLibrary& library, std::span<const int> prefix, int n,
                                          std::span<const double> weights);

/// Counts the type sequences that match `pattern`, part after part: {{kJoint}, {kLink, 0, 3}, {kJoint}} are two joints
/// with up to three links between them. A sequence that matches in several ways counts once.
/// Throws std::invalid_argument for a part that is not 0 <= least <= most <= 64.
[[nodiscard]] SequenceCount count_sequences(const ModuleLibrary& library, const std::vector<PatternPart>& pattern);

}  // namespace modsearch
