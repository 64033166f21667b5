#include <modsearch/rl/actor_gradient.hpp>
#include <modsearch/rl/pdqn.hpp>

namespace modsearch {

Pdqn::Pdqn(ValueKind kind, HybridSpace space, int observation_size, AgentOptions options, Rng rng)
    : kind_{kind},
      space_{std::move(space)},
      observation_size_{observation_size},
      options_{std::move(options)},
      values_{kind_, space_, observation_size, options_, rng},
      actor_{space_, observation_size, 0, options_, rng} {}

std::string Pdqn::name() const {
  switch (kind_) {
    case ValueKind::kJoint:
      return "pdqn";
    case ValueKind::kMultiPass:
      return "mpdqn";
    case ValueKind::kSeparate:
      return "spdqn";
  }
  return "";
}

// k = argmax_k Q(s, mu(s))_k
HybridAction Pdqn::do_greedy(const Eigen::VectorXf& s, ActionMask mask) {
  HybridAction action;
  action.x = actor_.acting().forward_one(s);
  if (options_.clip_parameters) action.x = action.x.cwiseMax(-1.0F).cwiseMin(1.0F);
  action.k = best_action(values_.q().forward_one(s, action.x), mask);
  return action;
}

// Algorithm 1 of Xiong et al. 2018: the values learn, then the actor climbs them, then the targets follow.
UpdateFacts Pdqn::update(const Batch& batch, Rng& rng) {
  UpdateFacts facts;
  // L = mean_B (Q(s, x)_k - y)^2
  values_.fit(batch.s, batch.x, batch.k, targets(batch, rng), options_.value_rate * rate_factor_, facts);
  if (++updates_ % options_.td3.delay != 0) return facts;
  learn_actor(batch, rng, facts);
  values_.follow();
  actor_.follow();
  return facts;
}

// y = r + gamma (1 - d) max_k Q'(s', mu'(s'))_k; gamma (1 - d) is the batch's discount.
Eigen::VectorXf Pdqn::targets(const Batch& batch, Rng& rng) {
  RowMatrixXf x_next = actor_.target.forward(batch.s_next);
  add_smoothing_noise(options_.td3, rng, x_next);
  const RowMatrixXf q = values_.target(batch.s_next, x_next);
  Eigen::VectorXf y = batch.reward;
  for (Eigen::Index row = 0; row < y.size(); ++row) {
    const int k = best_action(q.row(row).transpose(), batch.next_mask[static_cast<std::size_t>(row)]);
    if (k >= 0) y[row] += batch.discount[row] * q(row, k);
  }
  const auto beta = static_cast<float>(options_.mixed_target);
  return beta * batch.remaining + (1.0F - beta) * y;
}

// J = mean_B sum_k w_k Q(s, mu(s))_k; the actor follows dJ/dx, bent at the bounds, through mu.
void Pdqn::learn_actor(const Batch& batch, Rng& rng, UpdateFacts& facts) {
  const RowMatrixXf& x = actor_.mu.forward(batch.s);
  RowMatrixXf g = RowMatrixXf::Zero(x.rows(), x.cols());
  if (options_.model.critic != 0.0) {
    ActionValues& q = values_.q();
    static_cast<void>(q.forward(batch.s, x));
    g = static_cast<float>(options_.model.critic) * q.parameters_gradient(weights(batch, rng));
    if (options_.zero_index_gradients) keep_taken_slices(batch, space_, g);
  }
  if (options_.model.any()) {
    facts.work += add_model_gradient(batch, space_, options_.model, x, g);
  }
  facts.actor_gradient = actor_.climb(std::move(g), batch.s, x, rate_factor_);
}

// dJ/dQ [B x K]: the weights w_k, divided by B.
RowMatrixXf Pdqn::weights(const Batch& batch, Rng& rng) const {
  const int n = space_.n_actions();
  Eigen::VectorXf w = Eigen::VectorXf::Ones(n);
  switch (options_.weighting) {
    case ActorWeighting::kSum:
      break;
    case ActorWeighting::kWeighted:
      w.setZero();
      for (const int k : batch.k) w[k] += 1.0F / static_cast<float>(batch.size());
      break;
    case ActorWeighting::kAverage:
      w.setConstant(1.0F / static_cast<float>(n));
      break;
    case ActorWeighting::kRandom:
      for (float& value : w) value = static_cast<float>(rng.uniform());
      w.normalize();
      break;
  }
  w /= static_cast<float>(batch.size());
  if (!options_.indexed) return w.transpose().replicate(batch.size(), 1);
  RowMatrixXf taken = RowMatrixXf::Zero(batch.size(), n);
  for (int row = 0; row < batch.size(); ++row) taken(row, batch.k[row]) = w[batch.k[row]];
  return taken;
}

std::vector<StatePart> Pdqn::state() {
  std::vector<StatePart> parts{state_part("rate_factor", rate_factor_), state_part("updates", updates_)};
  actor_.append_state(parts);
  values_.append_state(parts, true);
  return parts;
}

}  // namespace modsearch
