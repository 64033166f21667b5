#include <algorithm>
#include <modsearch/rl/acting.hpp>

namespace modsearch {
namespace {

void polish_action(const ActionModel& model, const HybridSpace& space, const ActingOptions& options,
                   HybridAction& action, Work& work) {
  auto x_k = action.x.segment(space.offset(action.k), space.count(action.k));
  polish(model, action.k, {x_k.data(), static_cast<std::size_t>(x_k.size())}, options.polish, options.polishing, work);
}

}  // namespace

HybridAction refined(const HybridAction& action, const Environment& environment, const ActingOptions& options, Rng& rng,
                     Work& work) {
  const HybridSpace& space = environment.space();
  const std::shared_ptr<const ActionModel> model = options.polish > 0 ? environment.model() : nullptr;
  HybridAction best = action;
  if (model) polish_action(*model, space, options, best, work);
  if (options.proposals <= 1) return best;

  const auto reward = [&](const HybridAction& candidate) {
    const auto x_k = candidate.x.segment(space.offset(candidate.k), space.count(candidate.k));
    return environment.preview(candidate.k, {x_k.data(), static_cast<std::size_t>(x_k.size())});
  };
  std::optional<double> best_reward = reward(best);
  for (int k = 0; k < space.n_actions() && best_reward; ++k) {
    if (!(environment.mask() >> k & 1) || (k != action.k && !options.all_types)) continue;
    for (int i = k == action.k ? 1 : 0; i < options.proposals; ++i) {
      HybridAction candidate = action;
      candidate.k = k;
      if (i > 0) {
        for (float& value : candidate.x.segment(space.offset(k), space.count(k))) {
          value = std::clamp(value + static_cast<float>(options.proposal_deviation * rng.normal()), -1.0F, 1.0F);
        }
      }
      if (model) polish_action(*model, space, options, candidate, work);
      const std::optional<double> candidate_reward = reward(candidate);
      if (!candidate_reward) return best;
      if (*candidate_reward > *best_reward) {
        best = std::move(candidate);
        best_reward = candidate_reward;
      }
    }
  }
  return best;
}

}  // namespace modsearch
