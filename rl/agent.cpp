#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <modsearch/rl/agent.hpp>
#include <stdexcept>

namespace modsearch {

void Batch::resize(int rows, int observation_size, int memory_size) {
  const auto n = static_cast<std::size_t>(rows);
  s.resize(rows, observation_size);
  k.resize(rows);
  x.resize(rows, memory_size);
  reward.resize(rows);
  discount.resize(rows);
  remaining.resize(rows);
  s_next.resize(rows, observation_size);
  next_mask.resize(n);
  model.resize(n);
}

HybridAction Agent::greedy(const Eigen::VectorXf& s, ActionMask mask) {
  if (s.size() != observation_size()) {
    throw std::invalid_argument(
        fmt::format("{}: a state of {} numbers, {} are needed", name(), s.size(), observation_size()));
  }
  if ((mask & space().all()) == 0) throw std::invalid_argument(fmt::format("{}: no action is allowed", name()));
  return do_greedy(s, mask);
}

HybridAction Agent::random(ActionMask mask, Rng& rng) const {
  HybridAction action;
  action.k = random_action(mask, rng);
  action.x.resize(space().n_parameters());
  for (float& value : action.x) value = static_cast<float>(rng.uniform(-1.0, 1.0));
  return action;
}

void Agent::remember(const HybridAction& action, std::span<float> memory) const {
  std::copy(action.x.begin(), action.x.end(), memory.begin());
}

StatePart state_part(std::string name, Eigen::VectorXf& values, bool policy) {
  return {std::move(name), std::as_writable_bytes(std::span{values.data(), static_cast<std::size_t>(values.size())}),
          policy};
}

int best_action(const Eigen::Ref<const Eigen::VectorXf>& values, ActionMask mask) {
  int best = -1;
  for (int k = 0; k < values.size(); ++k) {
    if ((mask >> k & 1) && (best < 0 || values[k] > values[best])) best = k;
  }
  return best;
}

int random_action(ActionMask mask, Rng& rng) {
  int left = rng.index(std::popcount(mask));
  for (int k = 0; k < HybridSpace::kMaxActions; ++k) {
    if ((mask >> k & 1) && left-- == 0) return k;
  }
  return -1;
}

}  // namespace modsearch
