#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/rl/agents.hpp>
#include <modsearch/rl/dqn.hpp>
#include <modsearch/rl/paddpg.hpp>
#include <modsearch/rl/pdqn.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

void check(const AgentOptions& options) {
  const auto require = [](bool holds, const char* what, double value, const char* limit) {
    if (!holds) throw std::invalid_argument(fmt::format("agent: {} = {}, not in {}", what, value, limit));
  };
  const auto share = [&](const char* what, double value) {
    require(value >= 0.0 && value <= 1.0, what, value, "[0, 1]");
  };
  const auto positive = [&](const char* what, double value) {
    require(value > 0.0 && std::isfinite(value), what, value, "(0, inf)");
  };
  const auto not_negative = [&](const char* what, double value) {
    require(value >= 0.0 && std::isfinite(value), what, value, "[0, inf)");
  };
  const auto widths = [&](const char* what, const std::vector<int>& hidden) {
    constexpr double kWidest = 16384.0;  // a layer of it squared takes 1 GiB
    for (const int width : hidden) require(width >= 1 && width <= kWidest, what, width, "[1, 16384]");
    require(hidden.size() <= 16, "number of hidden layers", static_cast<double>(hidden.size()), "[0, 16]");
  };
  widths("width of a hidden layer of the value network", options.value_hidden);
  widths("width of a hidden layer of the actor", options.actor_hidden);
  share("gamma", options.gamma);
  share("tau of the values", options.value_tau);
  share("tau of the actor", options.actor_tau);
  share("share of the whole return in targets", options.mixed_target);
  positive("learning rate of the values", options.value_rate);
  positive("learning rate of the actor", options.actor_rate);
  positive("width of the model gradient", options.model.width);
  positive("width of the pull", options.model.pull_width);
  require(options.model.pull_aim > 0.0 && options.model.pull_aim <= 1.0, "aim of the pull", options.model.pull_aim,
          "(0, 1]");
  require(options.model.pull_steps >= 1, "steps of the pull's polish", options.model.pull_steps, "[1, ..)");
  require(options.bound >= 1.0, "bound of the parameters' gradients", options.bound, "[1, inf)");
  require(options.td3.delay >= 1, "updates of the values per update of the actor", options.td3.delay, "[1, ..)");
  not_negative("smoothing of the target parameters", options.td3.smoothing);
  not_negative("clip of that smoothing", options.td3.smoothing_clip);
  not_negative("learning rate of the passthrough", options.passthrough_rate);
  not_negative("deviation of the passthrough's bias", options.passthrough_bias_deviation);
  not_negative("deviation of the passthrough's weights", options.passthrough_weight_deviation);
}

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
  check(options);
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
