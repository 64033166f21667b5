#pragma once

#include <modsearch/rl/agent.hpp>
#include <modsearch/rl/agent_options.hpp>
#include <modsearch/rl/mlp.hpp>

namespace modsearch {

/// DQN (Mnih et al. 2015) on a discretised action space: every parameter takes one of `bins` evenly spaced values in
/// [-1, 1], so that action k stands for bins^n_k discrete ones. The simple way to treat a hybrid space, and its price:
/// the number of actions grows with a power of the precision.
class Dqn final : public Agent {
 public:
  static constexpr int kMaxBinnedActions = 65'536;

  /// Throws std::invalid_argument if bins < 2 or there are more than kMaxBinnedActions actions.
  Dqn(HybridSpace space, int observation_size, AgentOptions options, Rng rng);

  [[nodiscard]] std::string name() const override { return "dqn"; }
  [[nodiscard]] const HybridSpace& space() const override { return space_; }
  [[nodiscard]] int observation_size() const override { return observation_size_; }
  [[nodiscard]] double gamma() const override { return options_.gamma; }
  /// The type uniform, then each of its parameters uniform among the bins.
  [[nodiscard]] HybridAction random(ActionMask mask, Rng& rng) const override;
  /// The number of the discrete action with the nearest values.
  [[nodiscard]] int memory_size() const override { return 1; }
  void remember(const HybridAction& action, std::span<float> memory) const override;
  UpdateFacts update(const Batch& batch, Rng& rng) override;
  void set_rate_factor(double factor) override { rate_factor_ = factor; }
  [[nodiscard]] std::vector<StatePart> state() override;

  [[nodiscard]] int n_binned_actions() const { return first_.back(); }

 private:
  HybridAction do_greedy(const Eigen::VectorXf& s, ActionMask mask) override;
  [[nodiscard]] HybridAction action_of(int binned) const;
  [[nodiscard]] int best_binned(const Eigen::Ref<const Eigen::VectorXf>& q, ActionMask mask) const;

  HybridSpace space_;
  int observation_size_;
  AgentOptions options_;
  std::vector<int> first_;  // [K + 1], number of the first discrete action of k
  Mlp q_;
  Mlp q_target_;
  Mlp::Pass pass_;
  Mlp::Pass target_pass_;
  Adam adam_;
  Eigen::VectorXf gradient_;
  double rate_factor_ = 1.0;
};

}  // namespace modsearch
