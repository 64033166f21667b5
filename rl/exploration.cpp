#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/rl/exploration.hpp>
#include <stdexcept>

namespace modsearch {

Exploration::Exploration(ExplorationOptions options, int n_parameters)
    : options_{options}, state_{Eigen::VectorXf::Zero(n_parameters)} {
  const auto require = [](bool holds, const char* what, double value, const char* limit) {
    if (!holds) throw std::invalid_argument(fmt::format("exploration: {} = {}, not in {}", what, value, limit));
  };
  require(options_.first_epsilon >= 0.0 && options_.first_epsilon <= 1.0, "first epsilon", options_.first_epsilon,
          "[0, 1]");
  require(options_.last_epsilon >= 0.0 && options_.last_epsilon <= 1.0, "last epsilon", options_.last_epsilon,
          "[0, 1]");
  require(options_.deviation >= 0.0, "deviation of the noise", options_.deviation, "[0, inf)");
  require(options_.theta > 0.0 && options_.theta <= 1.0, "theta", options_.theta, "(0, 1]");
}

double Exploration::epsilon(std::int64_t episode) const {
  if (episode >= options_.epsilon_episodes) return options_.last_epsilon;
  const double share = static_cast<double>(episode) / static_cast<double>(options_.epsilon_episodes);
  return options_.first_epsilon + (options_.last_epsilon - options_.first_epsilon) * share;
}

void Exploration::begin_episode(Rng& rng) {
  if (options_.noise != NoiseKind::kOrnsteinUhlenbeck) return;
  for (float& value : state_) value = static_cast<float>(options_.deviation * rng.normal());
}

HybridAction Exploration::act(Agent& agent, const Eigen::VectorXf& s, ActionMask mask, std::int64_t episode, Rng& rng) {
  if (rng.uniform() < epsilon(episode)) return agent.random(mask, rng);
  HybridAction action = agent.greedy(s, mask);
  if (options_.noise == NoiseKind::kNone) return action;
  const int first = agent.space().offset(action.k);
  const int count = agent.space().count(action.k);
  // X <- (1 - theta) X + b w has the stationary deviation b / sqrt(1 - (1 - theta)^2); theta = 1 is white noise.
  const double theta = options_.noise == NoiseKind::kGaussian ? 1.0 : options_.theta;
  const double b = options_.deviation * std::sqrt(1.0 - (1.0 - theta) * (1.0 - theta));
  for (float& value : state_) value = static_cast<float>((1.0 - theta) * value + b * rng.normal());
  auto x_k = action.x.segment(first, count);
  x_k = (x_k + state_.segment(first, count)).cwiseMax(-1.0F).cwiseMin(1.0F);
  return action;
}

}  // namespace modsearch
