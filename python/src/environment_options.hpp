#pragma once

#include <nanobind/nanobind.h>

#include <modsearch/rl/design_environment.hpp>
#include <optional>
#include <string>

namespace modsearch::python {

/// A family of problems from Python: a problem (always that one), or a file or ID, of which `instance` (seed, index) is
/// taken, or a new instance for every episode where that is None.
[[nodiscard]] ProblemSource source_from(nanobind::handle problem, nanobind::handle instance);

/// Options by the names of the agents' settings. Throws std::invalid_argument for a name that is unknown.
[[nodiscard]] DesignEnvironmentOptions environment_options(const std::string& reward, const std::string& end_on,
                                                           const std::string& fidelity,
                                                           const std::optional<std::string>& level);

}  // namespace modsearch::python
