#pragma once

#include <modsearch/baselines/certify/node_bound_internal.hpp>

namespace modsearch::certify {

/// A row that may hold the arm off an obstacle in a box.
struct RowCandidate {
  Row row;
  double cut = 0.0;     ///< how far the row moves the body point off the middle of the box [m]; negative: not at all
  double blunt = 0.0;   ///< what the reach of the point in the box costs, or of faces may cost [m]
  bool inside = false;  ///< the body point is inside the obstacle in all of the box
};

/// The rows of `bound`'s box that cut most, the best first: one for each pair of a straight body and an obstacle shape
/// that may touch in the box, at the best of some points along the body, and those of `before` that counted, with their
/// multipliers.
void find_rows(const NodeBound& bound, const SequenceModel& model, const Scenery& scenery,
               const std::vector<Row>& before, std::vector<RowCandidate>& result);

}  // namespace modsearch::certify
