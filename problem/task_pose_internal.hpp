#pragma once

// Poses with tolerances as tasks write them. Internal to the problem floor.

#include <modsearch/kinematics/pose_region.hpp>
#include <modsearch/problem/base_placement.hpp>
#include <modsearch/problem/task_frames_internal.hpp>
#include <optional>

namespace modsearch::detail {

/// A pose with its tolerances, or with CoBRA's default ones.
[[nodiscard]] PoseRegion read_region(const JsonCursor& cursor, const TaskFrames& frames);

/// Where the base of an arm stands.
struct BaseOfTask {
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();  ///< nominal
  std::optional<BasePlacement> placement{};                ///< within tolerances that leave something to choose
};
/// A base within tolerances: intervals of x, y and z, all in one frame, and of its rotation, of which the turn about
/// its own z axis is used. Nothing is said of a rotation without tolerances, so that turn is free; a translation
/// without them would be free without bounds and stays 0, as do tilts. Intervals within CoBRA's default tolerance (1
/// mm, 0.5 degrees) say how exactly a base is mounted, not that it may be placed: 0.
[[nodiscard]] BaseOfTask read_base(const JsonCursor& cursor, const TaskFrames& frames);

}  // namespace modsearch::detail
