#pragma once

#include <string>
#include <vector>

#include "table1/cell.hpp"

namespace table1 {

/// The table: one line per row name, in the order of first appearance, with intervals over its trainings. Markdown.
[[nodiscard]] std::string summary_markdown(const std::vector<CellResult>& cells);

/// How often `request.ik` misses designs that the exact inverse kinematics reaches: random designs of one, two and
/// three modules for the request's problem. Markdown.
[[nodiscard]] std::string failure_rates_markdown(const CellRequest& request);

}  // namespace table1
