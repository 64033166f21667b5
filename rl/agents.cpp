#include <algorithm>
#include <array>
#include <modsearch/rl/agents.hpp>
#include <modsearch/rl/dqn.hpp>
#include <modsearch/rl/paddpg.hpp>
#include <modsearch/rl/pdqn.hpp>

namespace modsearch {
namespace {

constexpr std::array kKinds{AgentKind::kPdqn, AgentKind::kMpdqn, AgentKind::kSpdqn, AgentKind::kPaddpg,
                            AgentKind::kDqn};

}  // namespace

std::string_view name(AgentKind kind) {
  switch (kind) {
    case AgentKind::kPdqn:
      return "pdqn";
    case AgentKind::kMpdqn:
      return "mpdqn";
    case AgentKind::kSpdqn:
      return "spdqn";
    case AgentKind::kPaddpg:
      return "paddpg";
    case AgentKind::kDqn:
      return "dqn";
  }
  return "";
}

std::string_view meaning(AgentKind kind) {
  switch (kind) {
    case AgentKind::kPdqn:
      return "P-DQN: an actor proposes parameters for all types, one value network chooses the type";
    case AgentKind::kMpdqn:
      return "MP-DQN: the same, each type's value sees its own parameters only, by one pass per type";
    case AgentKind::kSpdqn:
      return "SP-DQN: the same, by one value network per type";
    case AgentKind::kPaddpg:
      return "PA-DDPG: one actor for preferences and parameters, one critic of both";
    case AgentKind::kDqn:
      return "DQN on binned parameters: the plain method, for comparison";
  }
  return "";
}

std::optional<AgentKind> agent_kind_from_name(std::string_view text) {
  const auto found = std::find_if(kKinds.begin(), kKinds.end(), [&](AgentKind kind) { return name(kind) == text; });
  return found == kKinds.end() ? std::nullopt : std::optional{*found};
}

std::span<const AgentKind> agent_kinds() { return kKinds; }

std::unique_ptr<Agent> make_agent(AgentKind kind, const HybridSpace& space, int observation_size,
                                  const AgentOptions& options, Rng rng) {
  switch (kind) {
    case AgentKind::kPdqn:
      return std::make_unique<Pdqn>(ValueKind::kJoint, space, observation_size, options, rng);
    case AgentKind::kMpdqn:
      return std::make_unique<Pdqn>(ValueKind::kMultiPass, space, observation_size, options, rng);
    case AgentKind::kSpdqn:
      return std::make_unique<Pdqn>(ValueKind::kSeparate, space, observation_size, options, rng);
    case AgentKind::kPaddpg:
      return std::make_unique<Paddpg>(space, observation_size, options, rng);
    case AgentKind::kDqn:
      return std::make_unique<Dqn>(space, observation_size, options, rng);
  }
  return nullptr;
}

}  // namespace modsearch
