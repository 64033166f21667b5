#pragma once

#include <modsearch/solvers/meter.hpp>

namespace modsearch {

/// Evaluates from cheap to dear: where the problem has stages (a path to plan), the screen comes first, and the full
/// evaluation only if the screen, which is an upper bound, could beat the best so far. Both are charged.
/// `witness`: postures to try first. Nothing when the meter says stop.
[[nodiscard]] std::optional<Evaluation> evaluate_staged(Meter& meter, const DesignProblem& problem,
                                                        const Design& design, const Witness& witness = {});

}  // namespace modsearch
