#pragma once

#include <modsearch/rl/agent.hpp>

namespace modsearch {

enum class NoiseKind {
  kNone,
  kGaussian,           ///< independent
  kOrnsteinUhlenbeck,  ///< correlated in time (Lillicrap et al. 2016, section 7)
};

/// How training departs from the greedy action.
struct ExplorationOptions {
  double first_epsilon = 1.0;              ///< share of uniform actions in the first episode
  double last_epsilon = 0.01;              ///< and from `epsilon_episodes` on; the report
  std::int64_t epsilon_episodes = 47'000;  ///< episodes of the linear fall; the report
  NoiseKind noise = NoiseKind::kNone;      ///< on the chosen action's parameters, where the action is not uniform
  double deviation = 0.1;                  ///< of the noise, stationary, in scaled units (the range is 2)
  double theta = 0.15;  ///< Ornstein-Uhlenbeck only: share of the state lost per step (Lillicrap et al.)
};

/// Epsilon-greedy in hybrid spaces: with probability epsilon the type and all parameters are uniform; else greedy, with
/// noise on x_k. Epsilon falls linearly in episodes.
class Exploration {
 public:
  /// Throws std::invalid_argument for numbers outside their ranges.
  Exploration(ExplorationOptions options, int n_parameters);

  [[nodiscard]] double epsilon(std::int64_t episode) const;
  /// The action taken in episode `episode` at state s. How much it draws depends on what it does: episodes need
  /// streams of their own.
  [[nodiscard]] HybridAction act(Agent& agent, const Eigen::VectorXf& s, ActionMask mask, std::int64_t episode,
                                 Rng& rng);
  /// The noise process starts anew, from its stationary distribution: episodes may be too short to get there.
  void begin_episode(Rng& rng);
  [[nodiscard]] Eigen::VectorXf& state() { return state_; }

 private:
  ExplorationOptions options_;
  Eigen::VectorXf state_;  // of the Ornstein-Uhlenbeck process [D]
};

}  // namespace modsearch
