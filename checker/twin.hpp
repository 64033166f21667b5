#pragma once

#include <checker/bound.hpp>

namespace modsearch_check {

/// Throws Rejected unless half a circle is enough of `variable`, an angle, because every posture in `root`, the box of
/// everything, has a twin in it: the same lengths, the same tips, the same points of all bodies that rows may use, and
/// this angle half a turn further. Nothing before the variable is changed.
///
/// With R' = R D after the joint, D half a turn about its axis, the frames behind it are R_j' = R_j D_j. From frame to
/// frame, R_(j+1) = R_j T Rz(q), and with E = T' D_j T
///     E = Rz(pi):            q' = q + pi gives D = 1, and all behind is as it was;  q' = q gives D = E
///     E half a turn about another axis, x or y:  q' = -q gives D = E, since E Rz(-q) = Rz(q) E.
/// In the twin everything lies where it was if no vector of frame j, for any lengths, is changed by D_j.
void require_twins(const Model& model, const Box& root, std::size_t variable);

}  // namespace modsearch_check
