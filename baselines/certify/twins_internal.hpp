#pragma once

#include <modsearch/baselines/certify/sequence_model_internal.hpp>

namespace modsearch::certify {

/// Variables, in rising order, of which half a circle is enough: every posture has a twin with that angle half a turn
/// further, other angles turned over or half a turn further as well, in which the tip and all bodies lie where they
/// were. The usual one is the base before a hinge.
[[nodiscard]] std::vector<int> half_circles(const SequenceModel& model, int n_goals);

/// The box of everything (root_box) but for the other halves of those circles.
[[nodiscard]] Box box_without_twins(const SequenceModel& model, int n_goals);

}  // namespace modsearch::certify
