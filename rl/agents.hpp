#pragma once

#include <memory>
#include <modsearch/rl/agent.hpp>
#include <modsearch/rl/agent_options.hpp>
#include <optional>
#include <span>
#include <string_view>

namespace modsearch {

/// The learning methods there are.
enum class AgentKind { kPdqn, kMpdqn, kSpdqn, kPaddpg, kDqn };
/// "pdqn", "mpdqn", "spdqn", "paddpg", "dqn".
[[nodiscard]] std::string_view name(AgentKind kind);
/// One line for people: what it is.
[[nodiscard]] std::string_view meaning(AgentKind kind);
[[nodiscard]] std::optional<AgentKind> agent_kind_from_name(std::string_view name);
[[nodiscard]] std::span<const AgentKind> agent_kinds();

/// A new agent; its first weights come from `rng`. Throws std::invalid_argument for options that do not fit the space.
[[nodiscard]] std::unique_ptr<Agent> make_agent(AgentKind kind, const HybridSpace& space, int observation_size,
                                                const AgentOptions& options, Rng rng);

}  // namespace modsearch
