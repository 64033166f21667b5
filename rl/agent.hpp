#pragma once

#include <cstddef>
#include <memory>
#include <modsearch/rl/environment.hpp>
#include <span>
#include <string>
#include <vector>

namespace modsearch {

/// A minibatch [B rows], as an agent's update needs it.
struct Batch {
  RowMatrixXf s;              ///< [B x observation_size]
  Eigen::VectorXi k;          ///< actions taken [B]
  RowMatrixXf x;              ///< what the agent remembers of them [B x memory_size]; parameters of all actions mostly
  Eigen::VectorXf reward;     ///< sum of the (scaled, discounted) rewards up to s_next [B]
  Eigen::VectorXf discount;   ///< of the value of s_next: gamma^n, or 0 where the episode has terminated [B]
  Eigen::VectorXf remaining;  ///< discounted return from s to the end of the episode, for mixed targets [B]
  RowMatrixXf s_next;         ///< [B x observation_size]
  std::vector<ActionMask> next_mask;      ///< [B]
  std::vector<const ActionModel*> model;  ///< of s, null where there is none [B]

  void resize(int rows, int observation_size, int memory_size);
  [[nodiscard]] int size() const { return static_cast<int>(k.size()); }
};

/// A named part of an agent's memory, for checkpoints and policy files.
struct StatePart {
  std::string name;
  std::span<std::byte> bytes;
  bool policy = false;  ///< needed for acting, not only for learning
};

/// What one update did.
struct UpdateFacts {
  double value_loss = 0.0;      ///< summed over the value networks, like their gradients
  double value_gradient = 0.0;  ///< norms before clipping
  double actor_gradient = 0.0;
  Work work;  ///< inner work of model gradients
};

/// Something that acts in a hybrid action space and learns from transitions.
class Agent {
 public:
  virtual ~Agent() = default;
  [[nodiscard]] virtual std::string name() const = 0;  ///< "pdqn", ..
  [[nodiscard]] virtual const HybridSpace& space() const = 0;
  [[nodiscard]] virtual int observation_size() const = 0;

  /// The best action at `s` [observation_size] among the allowed ones, the first of equals; x within [-1, 1]
  /// unless the agent's options leave it as proposed: environments clip what they take.
  /// Throws std::invalid_argument for an empty mask or another size of s.
  [[nodiscard]] HybridAction greedy(const Eigen::VectorXf& s, ActionMask mask);
  /// An action drawn uniformly among the allowed ones, all parameters uniform in [-1, 1].
  [[nodiscard]] virtual HybridAction random(ActionMask mask, Rng& rng) const;
  /// Numbers by which the agent remembers an action [memory_size]: the x of HybridAction unless it needs more.
  [[nodiscard]] virtual int memory_size() const { return space().n_parameters(); }
  virtual void remember(const HybridAction& action, std::span<float> memory) const;

  /// One step of learning. `rng`: for variants that draw (random weights, smoothing noise).
  virtual UpdateFacts update(const Batch& batch, Rng& rng) = 0;
  /// Scales all learning rates, for decay; 1 at first.
  virtual void set_rate_factor(double factor) = 0;
  /// Discount factor gamma by which returns are formed.
  [[nodiscard]] virtual double gamma() const = 0;

  /// All memory, in a fixed order: writing it back restores the agent bit by bit.
  [[nodiscard]] virtual std::vector<StatePart> state() = 0;

 private:
  virtual HybridAction do_greedy(const Eigen::VectorXf& s, ActionMask mask) = 0;
};

/// The bytes of something trivially copyable, as a part of a state.
template <typename T>
[[nodiscard]] StatePart state_part(std::string name, T& value, bool policy = false) {
  return {std::move(name), std::as_writable_bytes(std::span{&value, 1}), policy};
}
/// The numbers of a vector.
[[nodiscard]] StatePart state_part(std::string name, Eigen::VectorXf& values, bool policy = false);

/// The best allowed action by its value, the first of equals.
[[nodiscard]] int best_action(const Eigen::Ref<const Eigen::VectorXf>& values, ActionMask mask);

/// One of the allowed actions, each equally likely.
[[nodiscard]] int random_action(ActionMask mask, Rng& rng);

}  // namespace modsearch
