#pragma once

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
  RowMatrixXf x;              ///< parameters of all actions, as acted [B x D]
  Eigen::VectorXf reward;     ///< sum of the (scaled, discounted) rewards up to s_next [B]
  Eigen::VectorXf discount;   ///< of the value of s_next: gamma^n, or 0 where the episode has terminated [B]
  Eigen::VectorXf remaining;  ///< discounted return from s to the end of the episode, for mixed targets [B]
  RowMatrixXf s_next;         ///< [B x observation_size]
  std::vector<ActionMask> next_mask;       ///< [B]
  std::vector<const ActionModel*> model;   ///< of s, null where there is none [B]

  void resize(int rows, int observation_size, int n_parameters);
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
  double value_loss = 0.0;
  double value_gradient = 0.0;  ///< norms before clipping
  double actor_gradient = 0.0;
  Work work;                    ///< inner work of model gradients
};

/// Something that acts in a hybrid action space and learns from transitions.
class Agent {
 public:
  virtual ~Agent() = default;
  [[nodiscard]] virtual std::string name() const = 0;  ///< "pdqn", ..
  [[nodiscard]] virtual const HybridSpace& space() const = 0;
  [[nodiscard]] virtual int observation_size() const = 0;

  /// mu(s): the parameters of all actions, clipped to [-1, 1] by whoever acts [D].
  [[nodiscard]] virtual Eigen::VectorXf parameters(const Eigen::VectorXf& s) = 0;
  /// The values by which the discrete action is chosen at (s, x) [K].
  [[nodiscard]] virtual Eigen::VectorXf values(const Eigen::VectorXf& s, const Eigen::VectorXf& x) = 0;
  /// argmax_k values(s, mu(s)) among the allowed actions, the first of equals.
  [[nodiscard]] HybridAction greedy(const Eigen::VectorXf& s, ActionMask mask);

  /// One step of learning. `rng`: for variants that draw (random weights, smoothing noise).
  virtual UpdateFacts update(const Batch& batch, Rng& rng) = 0;
  /// Scales all learning rates, for decay; 1 at first.
  virtual void set_rate_factor(double factor) = 0;
  /// Discount factor gamma by which returns are formed.
  [[nodiscard]] virtual double gamma() const = 0;

  /// All memory, in a fixed order: writing it back restores the agent bit by bit.
  [[nodiscard]] virtual std::vector<StatePart> state() = 0;
};

}  // namespace modsearch
