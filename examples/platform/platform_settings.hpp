#pragma once

#include <modsearch/rl/agents.hpp>
#include <modsearch/rl/training.hpp>

namespace modsearch {

/// The settings with which Bester et al. 2019 (MP-DQN and its published code) trained an agent on Platform.
/// `prior`: with their frozen first guess of the parameters, run 3, hop 10 and leap 400; networks begin about 0
/// without.
[[nodiscard]] AgentOptions platform_agent_options(AgentKind kind, bool prior);
/// Likewise of the training. Two things differ, for the better: actions of exploration have random parameters (there,
/// noise of 2e-4 of their range), and the value of a state at which the time limit cuts in is kept.
[[nodiscard]] TrainingOptions platform_training_options(AgentKind kind, std::int64_t episodes);

}  // namespace modsearch
