#include <modsearch/rl/actor_gradient.hpp>
#include <modsearch/rl/paddpg.hpp>

namespace modsearch {

Paddpg::Paddpg(HybridSpace space, int observation_size, AgentOptions options, Rng rng)
    : space_{std::move(space)},
      observation_size_{observation_size},
      options_{std::move(options)},
      values_{ValueKind::kJoint, HybridSpace{{space_.n_actions() + space_.n_parameters()}}, observation_size, options_,
              rng},
      actor_{space_, observation_size, space_.n_actions(), options_, rng} {}

// (a, x) = mu(s), k = argmax a
HybridAction Paddpg::do_greedy(const Eigen::VectorXf& s, ActionMask mask) {
  const Eigen::VectorXf out = actor_.acting().forward_one(s);
  HybridAction action;
  action.preferences = out.head(space_.n_actions());
  action.x = out.tail(space_.n_parameters());
  if (options_.clip_parameters) action.x = action.x.cwiseMax(-1.0F).cwiseMin(1.0F);
  action.k = best_action(action.preferences, mask);
  return action;
}

HybridAction Paddpg::random(ActionMask mask, Rng& rng) const {
  HybridAction action = Agent::random(mask, rng);
  action.preferences.resize(space_.n_actions());
  for (float& a : action.preferences) a = static_cast<float>(rng.uniform(-1.0, 1.0));
  action.k = best_action(action.preferences, mask);
  return action;
}

void Paddpg::remember(const HybridAction& action, std::span<float> memory) const {
  const std::size_t n = static_cast<std::size_t>(space_.n_actions());
  std::copy(action.preferences.begin(), action.preferences.end(), memory.begin());
  Agent::remember(action, memory.subspan(n));
}

// The critic learns, then the actor climbs it, then the targets follow.
UpdateFacts Paddpg::update(const Batch& batch, Rng& rng) {
  UpdateFacts facts;
  // L = mean_B (Q(s, a, x) - y)^2
  values_.fit(batch.s, batch.x, Eigen::VectorXi::Zero(batch.size()), targets(batch, rng),
              options_.value_rate * rate_factor_, facts);
  if (++updates_ % options_.td3.delay != 0) return facts;
  learn_actor(batch, facts);
  values_.follow();
  actor_.follow();
  return facts;
}

// y = r + gamma (1 - d) Q'(s', mu'(s')); gamma (1 - d) is the batch's discount.
Eigen::VectorXf Paddpg::targets(const Batch& batch, Rng& rng) {
  RowMatrixXf next = actor_.target.forward(batch.s_next);
  add_smoothing_noise(options_.td3, rng, next);
  const Eigen::VectorXf q = values_.target(batch.s_next, next).col(0);
  const auto beta = static_cast<float>(options_.mixed_target);
  return beta * batch.remaining + (1.0F - beta) * (batch.reward + batch.discount.cwiseProduct(q));
}

// J = mean_B Q(s, mu(s)); preferences and parameters alike are held within bounds.
void Paddpg::learn_actor(const Batch& batch, UpdateFacts& facts) {
  const RowMatrixXf& action = actor_.mu.forward(batch.s);
  RowMatrixXf g = RowMatrixXf::Zero(action.rows(), action.cols());
  if (options_.model.critic != 0.0) {
    ActionValues& q = values_.q();
    static_cast<void>(q.forward(batch.s, action));
    const RowMatrixXf dj_dq = RowMatrixXf::Constant(batch.size(), 1, 1.0F / static_cast<float>(batch.size()));
    g = static_cast<float>(options_.model.critic) * q.parameters_gradient(dj_dq);
  }
  if (options_.model.any()) {
    const int n = space_.n_parameters();
    facts.work += add_model_gradient(batch, space_, options_.model, action.rightCols(n), g.rightCols(n));
  }
  facts.actor_gradient = actor_.climb(std::move(g), batch.s, action, rate_factor_);
}

std::vector<StatePart> Paddpg::state() {
  std::vector<StatePart> parts{state_part("rate_factor", rate_factor_), state_part("updates", updates_)};
  actor_.append_state(parts);
  values_.append_state(parts, false);
  return parts;
}

}  // namespace modsearch
