#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <modsearch/rl/hybrid_space.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace modsearch {

/// A trained policy as it is kept on disk: what is needed to build its agent again and to see that it fits a problem,
/// and where it comes from. It knows no agent; the settings are texts by name.
///
/// `policy.json` says everything but the weights:
///   { "modsearch": 1, "agent": "mpdqn", "settings": {"value_hidden": "128", ..},
///     "observationSize": 41, "actions": [{"type": "link", "parameters": 1}, ..],
///     "problem": file or ID, "library": name,
///     "training": {"version": .., "preset": .., "seed": .., "episodes": .., "steps": .., "updates": .., "seconds": ..,
///                  "meanReturn": .. or null},
///     "weights": {"file": .., "bytes": .., "crc32c": .., "tensors": [{"name": .., "offset": .., "count": ..}, ..]} }
/// The weights lie beside it in "<policy>-<checksum>.bin": little-endian float32, one tensor after the other, `offset`
/// in bytes, `count` in numbers.
struct PolicyFile {
  struct Action {
    std::string type;  ///< ID of the module type, in the order of the agent's actions
    int n_parameters = 0;

    friend bool operator==(const Action&, const Action&) = default;
  };
  struct Facts {
    std::string version{};  ///< of modsearch
    std::string preset{};   ///< from which the settings were made; empty: none
    std::uint64_t seed = 0;
    std::int64_t episodes = 0;  ///< of training
    std::int64_t steps = 0;     ///< of the environment
    std::int64_t updates = 0;
    double seconds = 0.0;               ///< of training [s]
    std::optional<double> mean_return{};  ///< of the greedy episodes at its end

    friend bool operator==(const Facts&, const Facts&) = default;
  };

  std::string agent;                            ///< "pdqn", ..
  std::map<std::string, std::string> settings;  ///< of agent, training, acting and observation encoder
  int observation_size = 0;
  std::vector<Action> actions;
  std::string problem;  ///< the family it was trained on: file or ID
  std::string library;  ///< its module library
  Facts training;
  std::vector<std::pair<std::string, std::vector<float>>> tensors;  ///< by name

  [[nodiscard]] HybridSpace space() const;

  friend bool operator==(const PolicyFile&, const PolicyFile&) = default;
};

/// Writes `policy` as `file` with its weights beside it, in place of a policy that is there: `file` names the new
/// weights only once they are on disk, so it is a whole policy at any time. Throws std::invalid_argument for a policy
/// that could not be read back (no action or more than 64, a name or type twice or empty, an observation without
/// numbers, weights that are not finite), FileError if it cannot be written.
void write_policy(const std::filesystem::path& file, const PolicyFile& policy);

/// Throws FileError (file, JSON pointer, value, limit) unless both files are as write_policy writes them.
[[nodiscard]] PolicyFile load_policy(const std::filesystem::path& file);

}  // namespace modsearch
