#pragma once

#include <modsearch/kinematics/path_planning.hpp>

namespace modsearch {

/// Whether `path` is within the limits and collision-free at every state that check_path looks at: PathCheck::free
/// alone, which costs a tenth of the clearances, and ends at the first state that is not. Throws like check_path.
[[nodiscard]] bool path_is_free(const Arm& arm, const Scene& scene, const Path& path, double resolution,
                                bool self_collision, Work& work);

}  // namespace modsearch
