#include "platform/platform_settings.hpp"

#include <algorithm>

namespace modsearch {

AgentOptions platform_agent_options(AgentKind kind, bool prior) {
  AgentOptions options;
  options.gamma = 0.9;
  options.value_hidden = options.actor_hidden = {128};
  options.value_rate = 1e-3;
  options.actor_rate = 1e-4;
  options.value_tau = 0.1;
  options.actor_tau = 0.001;
  options.clip = 10.0;
  options.actor_output_deviation = 1e-4;
  if (kind == AgentKind::kPaddpg) {
    options.value_hidden = options.actor_hidden = {256, 128};
    options.leak = 0.01;
    options.value_tau = options.actor_tau = 0.01;
    options.value_output_deviation = 0.01;
  }
  // 3 of [0, 30], 10 of [0, 720] and 400 of [0, 430], in [-1, 1].
  if (prior) options.passthrough_bias = {-0.8, -0.9722, 0.8605};
  return options;
}

TrainingOptions platform_training_options(AgentKind kind, std::int64_t episodes) {
  TrainingOptions options;
  options.episodes = episodes;
  options.replay = 10'000;
  options.batch = kind == AgentKind::kPaddpg ? 32 : 128;
  options.warm_up = kind == AgentKind::kPaddpg ? 128 : 500;
  options.exploration.epsilon_episodes = 1000;
  // Nothing depends on evaluations here: a look at every quarter.
  options.evaluate_every = static_cast<int>(std::max<std::int64_t>(1, episodes / 4));
  options.patience = 0;
  return options;
}

}  // namespace modsearch
