#pragma once

#include <modsearch/problem/design_problem.hpp>
#include <modsearch/problem/rng.hpp>

namespace modsearch {

/// Makes a design of any list of placements: a module that does not fit the one before gives way to one that does, what
/// comes after a module that nothing fits is dropped, and in a library with end effectors the design gets one.
void mend(const DesignProblem& problem, Design& design, Rng& rng);

/// `design` with one change of its sequence, mended: a random module inserted, removed or replaced, or two neighbours
/// swapped; each as likely as the others where it is possible.
[[nodiscard]] Design changed_sequence(const DesignProblem& problem, const Design& design, Rng& rng);

/// Parameters outside their intervals become the nearer bound.
void clamp(const ModuleLibrary& library, Design& design);

/// Number of parameters of all modules.
[[nodiscard]] int n_parameters(const Design& design);

}  // namespace modsearch
