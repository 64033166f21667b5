#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/rl/returns.hpp>
#include <stdexcept>

namespace modsearch {

Returns::Returns(ReturnOptions options, double gamma) : options_{options}, gamma_{gamma} {
  if (options_.steps < 1) throw std::invalid_argument(fmt::format("returns of {} steps, at least 1", options_.steps));
  if (!(gamma >= 0.0 && gamma <= 1.0)) throw std::invalid_argument(fmt::format("gamma = {}, not in [0, 1]", gamma));
}

std::vector<Experience> Returns::add(const Agent& agent, Transition transition) {
  const bool at_once = options_.steps == 1 && !options_.remaining;
  const bool ended = transition.terminated || transition.truncated;
  episode_.push_back(std::move(transition));
  if (!at_once && !ended) return {};

  std::vector<Experience> ready(episode_.size());
  double remaining = 0.0;  // G_t = r_t + gamma G_t+1
  for (int t = static_cast<int>(episode_.size()) - 1; t >= 0; --t) {
    const int end = std::min(t + options_.steps, static_cast<int>(episode_.size()));
    const Transition& first = episode_[static_cast<std::size_t>(t)];
    const Transition& last = episode_[static_cast<std::size_t>(end - 1)];
    double reward = 0.0;
    for (int i = end - 1; i >= t; --i) reward = episode_[static_cast<std::size_t>(i)].reward + gamma_ * reward;
    remaining = first.reward + gamma_ * remaining;

    Experience& experience = ready[static_cast<std::size_t>(t)];
    experience.s = first.s;
    experience.k = first.action.k;
    experience.memory.resize(agent.memory_size());
    agent.remember(first.action, {experience.memory.data(), static_cast<std::size_t>(experience.memory.size())});
    experience.reward = static_cast<float>(options_.reward_scale * reward);
    experience.discount = static_cast<float>(discount_after(last, end - t));
    experience.remaining = static_cast<float>(options_.reward_scale * remaining);
    experience.s_next = last.s_next;
    experience.next_mask = last.next_mask;
    experience.model = first.model;
  }
  episode_.clear();
  return ready;
}

double Returns::discount_after(const Transition& last, int steps) const {
  const bool nothing_follows = last.terminated || last.next_mask == 0;
  const bool ends = (nothing_follows && !options_.legacy_terminals) || (last.truncated && options_.truncation_ends);
  return ends ? 0.0 : std::pow(gamma_, steps);
}

}  // namespace modsearch
