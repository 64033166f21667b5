#pragma once

#include <string>
#include <vector>

#include "table1/cell.hpp"

namespace table1 {

/// What the curves of a training are held against: on the problems of each of its evaluations the mean return of
/// random actions, and of the best design there is (a single step; solved by PerSequence).
/// Columns: episode, random_return, best_return.
[[nodiscard]] std::string curve_lines_csv(const CellRequest& request,
                                          const std::vector<modsearch::EvaluationPoint>& history);

}  // namespace table1
