#pragma once

#include <modsearch/rl/agent.hpp>
#include <modsearch/rl/agent_options.hpp>
#include <modsearch/rl/learning_values.hpp>
#include <modsearch/rl/parameter_actor.hpp>

namespace modsearch {

/// PA-DDPG (Hausknecht and Stone 2016, "Deep reinforcement learning in parameterized action space", arXiv 1511.04143):
/// one actor for a preference a_k of every action and all parameters x, one critic Q(s, a, x) in R. The action is the
/// one with the largest preference. What may not be chosen is left out when acting; the critic does not know of it.
class Paddpg final : public Agent {
 public:
  /// options.weighting, .indexed and .zero_index_gradients have no meaning here.
  Paddpg(HybridSpace space, int observation_size, AgentOptions options, Rng rng);

  [[nodiscard]] std::string name() const override { return "paddpg"; }
  [[nodiscard]] const HybridSpace& space() const override { return space_; }
  [[nodiscard]] int observation_size() const override { return observation_size_; }
  [[nodiscard]] double gamma() const override { return options_.gamma; }
  /// Preferences and parameters uniform in [-1, 1]; the action follows from the preferences.
  [[nodiscard]] HybridAction random(ActionMask mask, Rng& rng) const override;
  /// Preferences, then parameters.
  [[nodiscard]] int memory_size() const override { return space_.n_actions() + space_.n_parameters(); }
  void remember(const HybridAction& action, std::span<float> memory) const override;
  UpdateFacts update(const Batch& batch, Rng& rng) override;
  void set_rate_factor(double factor) override { rate_factor_ = factor; }
  [[nodiscard]] std::vector<StatePart> state() override;

 private:
  HybridAction do_greedy(const Eigen::VectorXf& s, ActionMask mask) override;
  [[nodiscard]] Eigen::VectorXf targets(const Batch& batch, Rng& rng);
  void learn_actor(const Batch& batch, UpdateFacts& facts);

  HybridSpace space_;
  int observation_size_;
  AgentOptions options_;
  LearningValues values_;  // of one action, whose parameters are [a; x]
  LearningActor actor_;
  double rate_factor_ = 1.0;
  std::int64_t updates_ = 0;
};

}  // namespace modsearch
