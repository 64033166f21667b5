#pragma once

#include <memory>
#include <modsearch/rl/learner.hpp>
#include <modsearch/rl/policy_file.hpp>

namespace modsearch {

/// `policy` as a file keeps it. `problem`: file or ID of the family; `library`: its modules.
[[nodiscard]] PolicyFile describe(const Policy& policy, const ModuleLibrary& library, const std::string& problem,
                                  PolicyFile::Facts training);

/// The policy that a file describes. Throws std::invalid_argument (what, value, limit) for an agent or a setting that
/// is unknown, and for weights that do not fit them.
[[nodiscard]] std::unique_ptr<Policy> revive(const PolicyFile& file);

/// load_policy and revive. Throws FileError, naming the file.
[[nodiscard]] std::unique_ptr<Policy> load_trained_policy(const std::filesystem::path& file);

}  // namespace modsearch
