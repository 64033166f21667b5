#pragma once

#include <modsearch/rl/design_environment.hpp>
#include <string>

namespace modsearch {

/// The present state of an episode as a self-contained 3-D page: the design so far at the posture that comes closest to
/// its goals, the obstacles, the score's terms. Throws std::invalid_argument where the problem is no robot problem.
[[nodiscard]] std::string render(const DesignEnvironment& environment);

}  // namespace modsearch
