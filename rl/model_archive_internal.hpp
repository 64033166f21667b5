#pragma once

#include <memory>
#include <modsearch/rl/environment.hpp>
#include <modsearch/solvers/archive.hpp>
#include <string>
#include <vector>

namespace modsearch::detail {

/// Models by their keys: `name`.keys holds them one behind the other, `name`.ends where each one ends; a null model has
/// an empty key.
void put_models(Archive& archive, const std::string& name,
                const std::vector<std::shared_ptr<const ActionModel>>& models);
/// Throws FileError if there are not `count` of them, or a key is none of the environment's.
[[nodiscard]] std::vector<std::shared_ptr<const ActionModel>> get_models(const Archive& archive,
                                                                         const std::string& name, std::size_t count,
                                                                         const Environment& environment);

}  // namespace modsearch::detail
