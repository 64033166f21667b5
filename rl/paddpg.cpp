#include <fmt/format.h>

#include <modsearch/rl/actor_gradient.hpp>
#include <modsearch/rl/paddpg.hpp>

namespace modsearch {
namespace {

// [s; a; x], the critic's input.
RowMatrixXf beside(const RowMatrixXf& s, const RowMatrixXf& action) {
  RowMatrixXf both(s.rows(), s.cols() + action.cols());
  both << s, action;
  return both;
}

}  // namespace

Paddpg::Paddpg(HybridSpace space, int observation_size, AgentOptions options, Rng rng)
    : space_{std::move(space)},
      observation_size_{observation_size},
      options_{std::move(options)},
      actor_{space_, observation_size, space_.n_actions(), options_, rng} {
  for (std::uint64_t i = 0; i < (options_.td3.twin ? 2U : 1U); ++i) {
    Mlp q{{.inputs = observation_size + memory_size(),
           .hidden = options_.value_hidden,
           .outputs = 1,
           .leak = static_cast<float>(options_.leak)}};
    Rng weights = rng.fork("values").fork(i);
    q.initialise({.output_deviation = static_cast<float>(options_.value_output_deviation)}, weights);
    const Eigen::Index n = q.parameters().size();
    critics_.push_back({q, q, Adam{n, options_.adam()}, Eigen::VectorXf::Zero(n), {}, {}});
  }
}

// (a, x) = mu(s), k = argmax a
HybridAction Paddpg::do_greedy(const Eigen::VectorXf& s, ActionMask mask) {
  const Eigen::VectorXf out = actor_.mu.forward_one(s);
  HybridAction action;
  action.preferences = out.head(space_.n_actions());
  action.x = out.tail(space_.n_parameters());
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
  learn_values(batch, targets(batch, rng), facts);
  if (++updates_ % options_.td3.delay != 0) return facts;
  learn_actor(batch, facts);
  for (Critic& critic : critics_) {
    soft_update(critic.q_target.parameters(), critic.q.parameters(), static_cast<float>(options_.value_tau));
  }
  actor_.follow();
  return facts;
}

// y = r + gamma (1 - d) Q'(s', mu'(s')); gamma (1 - d) is the batch's discount.
Eigen::VectorXf Paddpg::targets(const Batch& batch, Rng& rng) {
  RowMatrixXf next = actor_.target.forward(batch.s_next);
  add_smoothing_noise(options_.td3, rng, next);
  const RowMatrixXf input = beside(batch.s_next, next);
  Eigen::VectorXf q = critics_.front().q_target.forward(input, critics_.front().target_pass).col(0);
  for (std::size_t i = 1; i < critics_.size(); ++i) {
    q = q.cwiseMin(critics_[i].q_target.forward(input, critics_[i].target_pass).col(0));
  }
  const auto beta = static_cast<float>(options_.mixed_target);
  return beta * batch.remaining + (1.0F - beta) * (batch.reward + batch.discount.cwiseProduct(q));
}

// L = mean_B (Q(s, a, x) - y)^2
void Paddpg::learn_values(const Batch& batch, const Eigen::VectorXf& y, UpdateFacts& facts) {
  const RowMatrixXf input = beside(batch.s, batch.x);
  for (Critic& critic : critics_) {
    const Eigen::VectorXf difference = critic.q.forward(input, critic.pass).col(0) - y;
    facts.value_loss += difference.squaredNorm() / static_cast<float>(batch.size());
    critic.gradient.setZero();
    critic.q.backward(2.0F / static_cast<float>(batch.size()) * difference, critic.pass, &critic.gradient, nullptr);
    facts.value_gradient += critic.adam.step(critic.q.parameters(), critic.gradient,
                                            static_cast<float>(options_.value_rate * rate_factor_));
  }
}

// J = mean_B Q(s, mu(s)); preferences and parameters alike are inverted at -1 and 1.
void Paddpg::learn_actor(const Batch& batch, UpdateFacts& facts) {
  const RowMatrixXf& action = actor_.mu.forward(batch.s);
  RowMatrixXf g = RowMatrixXf::Zero(action.rows(), action.cols());
  if (options_.model.critic != 0.0) {
    Critic& critic = critics_.front();
    static_cast<void>(critic.q.forward(beside(batch.s, action), critic.pass));
    const RowMatrixXf dj_dq = RowMatrixXf::Constant(batch.size(), 1, 1.0F / static_cast<float>(batch.size()));
    critic.q.backward(dj_dq, critic.pass, nullptr, &d_inputs_);
    g = static_cast<float>(options_.model.critic) * d_inputs_.rightCols(action.cols());
  }
  if (options_.model.reach != 0.0 || options_.model.mass != 0.0) {
    const int n = space_.n_parameters();
    facts.work += add_model_gradient(batch, space_, options_.model, action.rightCols(n), g.rightCols(n));
  }
  facts.actor_gradient = actor_.climb(std::move(g), action, options_.actor_rate * rate_factor_);
}

std::vector<StatePart> Paddpg::state() {
  std::vector<StatePart> parts{state_part("rate_factor", rate_factor_), state_part("updates", updates_)};
  actor_.append_state(parts);
  for (std::size_t i = 0; i < critics_.size(); ++i) {
    Critic& critic = critics_[i];
    const std::string q = fmt::format("q{}", i);
    parts.push_back(state_part(q, critic.q.parameters()));
    parts.push_back(state_part(q + ".target", critic.q_target.parameters()));
    parts.push_back(state_part(q + ".adam.m", critic.adam.m));
    parts.push_back(state_part(q + ".adam.v", critic.adam.v));
    parts.push_back(state_part(q + ".adam.steps", critic.adam.steps));
  }
  return parts;
}

}  // namespace modsearch
