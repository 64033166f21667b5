#pragma once

#include <modsearch/rl/agent.hpp>
#include <modsearch/rl/agent_options.hpp>
#include <modsearch/rl/learning_values.hpp>
#include <modsearch/rl/parameter_actor.hpp>

namespace modsearch {

/// P-DQN (Xiong et al. 2018, "Parametrized deep Q-networks learning", arXiv 1810.06394), MP-DQN and SP-DQN (Bester et
/// al. 2019, "Multi-pass Q-networks for deep reinforcement learning with parameterised action spaces", arXiv
/// 1905.04388).
///
/// A parameter actor mu(s) proposes x_k for every action at once, a value network Q(s, x) chooses k. The three differ
/// only in how Q reads x (ValueKind).
class Pdqn final : public Agent {
 public:
  Pdqn(ValueKind kind, HybridSpace space, int observation_size, AgentOptions options, Rng rng);

  [[nodiscard]] std::string name() const override;
  [[nodiscard]] const HybridSpace& space() const override { return space_; }
  [[nodiscard]] int observation_size() const override { return observation_size_; }
  [[nodiscard]] double gamma() const override { return options_.gamma; }
  UpdateFacts update(const Batch& batch, Rng& rng) override;
  void set_rate_factor(double factor) override { rate_factor_ = factor; }
  [[nodiscard]] std::vector<StatePart> state() override;

 private:
  HybridAction do_greedy(const Eigen::VectorXf& s, ActionMask mask) override;
  [[nodiscard]] Eigen::VectorXf targets(const Batch& batch, Rng& rng);
  void learn_actor(const Batch& batch, Rng& rng, UpdateFacts& facts);
  [[nodiscard]] RowMatrixXf weights(const Batch& batch, Rng& rng) const;

  ValueKind kind_;
  HybridSpace space_;
  int observation_size_;
  AgentOptions options_;
  LearningValues values_;
  LearningActor actor_;
  double rate_factor_ = 1.0;
  std::int64_t updates_ = 0;
};

}  // namespace modsearch
