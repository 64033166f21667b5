#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/rl/dqn.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

// [K + 1]: action k stands for the discrete actions first[k] .. first[k + 1] - 1.
std::vector<int> binned(const HybridSpace& space, int bins) {
  if (bins < 2) throw std::invalid_argument(fmt::format("dqn: bins = {}, at least 2 are needed", bins));
  std::vector<int> first{0};
  for (int k = 0; k < space.n_actions(); ++k) {
    const double total = first.back() + std::pow(bins, space.count(k));
    if (total > Dqn::kMaxBinnedActions) {
      throw std::invalid_argument(
          fmt::format("dqn: {} bins per parameter make more than {} discrete actions", bins, Dqn::kMaxBinnedActions));
    }
    first.push_back(static_cast<int>(total));
  }
  return first;
}

}  // namespace

Dqn::Dqn(HybridSpace space, int observation_size, AgentOptions options, Rng rng)
    : space_{std::move(space)},
      observation_size_{observation_size},
      options_{std::move(options)},
      first_{binned(space_, options_.bins)},
      q_{{.inputs = observation_size,
          .hidden = options_.value_hidden,
          .outputs = first_.back(),
          .leak = static_cast<float>(options_.leak)}},
      q_target_{q_},
      adam_{q_.parameters().size(), options_.adam()},
      gradient_{Eigen::VectorXf::Zero(q_.parameters().size())} {
  Rng weights = rng.fork("values");
  q_.initialise({.output_deviation = static_cast<float>(options_.value_output_deviation)}, weights);
  q_target_ = q_;
}

HybridAction Dqn::action_of(int binned) const {
  HybridAction action{.k = 0, .x = Eigen::VectorXf::Zero(space_.n_parameters()), .preferences = {}};
  while (binned >= first_[static_cast<std::size_t>(action.k) + 1]) ++action.k;
  int rest = binned - first_[static_cast<std::size_t>(action.k)];
  for (float& value : action.x.segment(space_.offset(action.k), space_.count(action.k))) {
    value = -1.0F + 2.0F * static_cast<float>(rest % options_.bins) / static_cast<float>(options_.bins - 1);
    rest /= options_.bins;
  }
  return action;
}

void Dqn::remember(const HybridAction& action, std::span<float> memory) const {
  int binned = first_[static_cast<std::size_t>(action.k)];
  int place = 1;
  for (const float value : action.x.segment(space_.offset(action.k), space_.count(action.k))) {
    const float scaled = (value + 1.0F) / 2.0F * static_cast<float>(options_.bins - 1);
    binned += place * std::clamp(static_cast<int>(std::lround(scaled)), 0, options_.bins - 1);
    place *= options_.bins;
  }
  memory.front() = static_cast<float>(binned);  // exact: below 2^24
}

int Dqn::best_binned(const Eigen::Ref<const Eigen::VectorXf>& q, ActionMask mask) const {
  int best = -1;
  for (int k = 0; k < space_.n_actions(); ++k) {
    if (!(mask >> k & 1)) continue;
    for (int i = first_[static_cast<std::size_t>(k)]; i < first_[static_cast<std::size_t>(k) + 1]; ++i) {
      if (best < 0 || q[i] > q[best]) best = i;
    }
  }
  return best;
}

HybridAction Dqn::do_greedy(const Eigen::VectorXf& s, ActionMask mask) {
  return action_of(best_binned(q_.forward_one(s, pass_), mask));
}

HybridAction Dqn::random(ActionMask mask, Rng& rng) const {
  const auto k = static_cast<std::size_t>(random_action(mask, rng));
  return action_of(first_[k] + rng.index(first_[k + 1] - first_[k]));
}

// Algorithm 1 of Mnih et al. 2015: y = r + gamma (1 - d) max_a Q'(s', a), L = mean_B (Q(s, a) - y)^2.
UpdateFacts Dqn::update(const Batch& batch, Rng&) {
  const RowMatrixXf& next = q_target_.forward(batch.s_next, target_pass_);
  Eigen::VectorXf y = batch.reward;
  for (int row = 0; row < batch.size(); ++row) {
    const int best = best_binned(next.row(row).transpose(), batch.next_mask[static_cast<std::size_t>(row)]);
    if (best >= 0) y[row] += batch.discount[row] * next(row, best);
  }
  const auto beta = static_cast<float>(options_.mixed_target);
  y = beta * batch.remaining + (1.0F - beta) * y;

  UpdateFacts facts;
  const RowMatrixXf& q = q_.forward(batch.s, pass_);
  RowMatrixXf dq = RowMatrixXf::Zero(q.rows(), q.cols());
  for (int row = 0; row < batch.size(); ++row) {
    const auto taken = static_cast<Eigen::Index>(batch.x(row, 0));
    const float difference = q(row, taken) - y[row];
    facts.value_loss += difference * difference / static_cast<float>(batch.size());
    dq(row, taken) = 2.0F * difference / static_cast<float>(batch.size());
  }
  gradient_.setZero();
  q_.backward(dq, pass_, &gradient_, nullptr);
  facts.value_gradient = adam_.step(q_.parameters(), gradient_, static_cast<float>(options_.value_rate * rate_factor_));
  soft_update(q_target_.parameters(), q_.parameters(), static_cast<float>(options_.value_tau));
  return facts;
}

std::vector<StatePart> Dqn::state() {
  return {state_part("q", q_.parameters(), true),  state_part("q.target", q_target_.parameters()),
          state_part("q.adam.m", adam_.m),         state_part("q.adam.v", adam_.v),
          state_part("q.adam.steps", adam_.steps), state_part("rate_factor", rate_factor_)};
}

}  // namespace modsearch
