#pragma once

#include <modsearch/rl/agent.hpp>
#include <modsearch/solvers/archive.hpp>
#include <span>
#include <string>

namespace modsearch {

/// Puts every part as the entry `prefix` + "/" + its name.
void put(Archive& archive, const std::string& prefix, std::span<const StatePart> parts);
/// Writes what put() has kept back into the parts. Throws FileError if an entry is missing or has another size than its
/// part; then no part has changed.
void restore(const Archive& archive, const std::string& prefix, std::span<const StatePart> parts);

}  // namespace modsearch
