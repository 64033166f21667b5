#include <modsearch/rl/hybrid_space.hpp>

#include <fmt/format.h>

#include <stdexcept>

namespace modsearch {

HybridSpace::HybridSpace(std::vector<int> parameters_per_action) : counts_{std::move(parameters_per_action)} {
  if (counts_.empty() || counts_.size() > kMaxActions) {
    throw std::invalid_argument(
        fmt::format("hybrid action space: {} discrete actions, not in [1, {}]", counts_.size(), kMaxActions));
  }
  offsets_.push_back(0);
  for (const int count : counts_) {
    if (count < 0) throw std::invalid_argument(fmt::format("hybrid action space: {} parameters of an action", count));
    offsets_.push_back(offsets_.back() + count);
  }
}

ActionMask HybridSpace::all() const {
  return n_actions() == kMaxActions ? ~ActionMask{0} : (ActionMask{1} << n_actions()) - 1;
}

}  // namespace modsearch
