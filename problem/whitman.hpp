#pragma once

#include <modsearch/problem/files.hpp>
#include <string>

namespace modsearch {

/// Task `instance.index` of seed `instance.seed` as a file of CoBRA's: the same text on every machine.
///
/// After the task sets Whitman2020/*g_*o of CoBRA, which regenerate the tasks of Whitman, Bhirangi, Travers and Choset
/// 2020, "Modular Robot Design Synthesis with Deep Reinforcement Learning" (AAAI, doi:10.1609/aaai.v34i06.6611):
/// `goals` poses to reach within 1 mm along each axis and 0.5 degrees among `boxes` boxes of 0.25 m on a grid of 0.25
/// m, the base fixed, joint torques limited.
///
/// The distribution is ours where theirs is not published. Boxes: distinct grid points with x and y in
/// {-0.5, -0.25, .., 0.5} and z in {0, 0.25, .., 1}, all alike, but none below z = 0.5 on the base's axis or next to it
/// along x or y: the arm has to begin somewhere. Goals: positions uniform in the unit cube
/// [-0.5, 0.5] x [-0.5, 0.5] x [0, 1] that stands around the base, drawn again within 0.06 m of a box or 0.2 m of the
/// base's axis below z = 0.5; orientations uniform over all rotations.
///
/// Of such tasks some are impossible, because every end effector overlaps a box at some goal (docs/infeasible.md). With
/// `free_ends` a goal is drawn again until at least one end effector of that library, at the nominal pose and with its
/// parameters at their lower ends, is 5 mm or more away from every box: a rule of its own, which does not change with
/// what can be proved. The stream of a goal goes on where it was, so that goals that are free from the beginning are
/// those of the same instance without the rule.
///
/// Throws std::invalid_argument unless goals and boxes are in [1, 20], and for free ends of a library without end
/// effectors; std::runtime_error if 10 000 goals in a row are not free.
[[nodiscard]] std::string whitman_task(const WhitmanTasks& tasks, Instance instance);

/// The library of the built-in families `whitman/*`.
[[nodiscard]] std::shared_ptr<const ModuleLibrary> whitman_library();

/// The problem file of one such task, which it names `task`: library, level and scoring are those of the built-in
/// families `whitman/*`.
[[nodiscard]] std::string whitman_problem(const std::string& task);

}  // namespace modsearch
