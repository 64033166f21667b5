#pragma once

#include <memory>
#include <modsearch/problem/rng.hpp>
#include <modsearch/rl/action_model.hpp>
#include <modsearch/rl/hybrid_space.hpp>
#include <span>
#include <string>
#include <vector>

namespace modsearch {

/// What a step brought.
struct Step {
  double reward = 0.0;
  bool terminated = false;  ///< the task itself has ended: no value follows
  bool truncated = false;   ///< cut off from outside (no module left, a time limit, a budget)
  bool success = false;     ///< the episode ended as it should
  bool unpaid = false;      ///< no reward could be found (the budget is over): nothing can be learned from the step
};

/// What an agent learns from: (s, k, x, r, s') and whatever the training needs beside it.
struct Transition {
  Eigen::VectorXf s{};  ///< [observation_size]
  HybridAction action{};
  float reward = 0.0F;
  Eigen::VectorXf s_next{};  ///< [observation_size]
  ActionMask next_mask = 0;
  bool terminated = false;
  bool truncated = false;
  std::shared_ptr<const ActionModel> model;  ///< of s; null where there is none
};

/// A Markov decision process with a hybrid action space: what agents train on and act in. Episodes are a function of
/// the random stream they are reset with and of the actions taken.
class Environment {
 public:
  virtual ~Environment() = default;

  [[nodiscard]] virtual std::string name() const = 0;
  [[nodiscard]] virtual const HybridSpace& space() const = 0;
  [[nodiscard]] virtual int observation_size() const = 0;
  /// An independent environment of the same kind, between episodes: for evaluation beside training.
  [[nodiscard]] virtual std::unique_ptr<Environment> clone() const = 0;

  /// Begins an episode; all its randomness comes from `rng`.
  void reset(Rng rng);
  /// Takes an action. Only the parameters of action k count; they are clipped to [-1, 1].
  /// Throws std::logic_error before the first reset and after the end of an episode, std::invalid_argument for an
  /// action that is masked, has other than D parameters, or parameters of k that are NaN.
  Step step(const HybridAction& action);

  /// State as the agent sees it [observation_size], finite, about in [-1, 1].
  [[nodiscard]] const Eigen::VectorXf& observation() const { return observation_; }
  /// Actions that may be taken now; never empty while an episode runs.
  [[nodiscard]] ActionMask mask() const { return mask_; }
  [[nodiscard]] bool running() const { return running_; }

  /// Look-ahead at the current state, or null where the environment has none.
  [[nodiscard]] virtual std::shared_ptr<const ActionModel> model() const { return nullptr; }
  /// The model whose key() was `key`. Throws std::invalid_argument for anything else.
  [[nodiscard]] virtual std::shared_ptr<const ActionModel> restore_model(std::span<const double> key) const;
  /// What step() would pay for action k with x_k, without taking it, or nothing where that cannot be said (or is over
  /// budget): by it one of several proposals is chosen.
  [[nodiscard]] virtual std::optional<double> preview(int k, std::span<const float> x_k) const;
  /// Up to `n` transitions like the last step, in tasks whose goal is what that step reached (hindsight experience
  /// replay, Andrychowicz et al. 2017); none by default.
  [[nodiscard]] virtual std::vector<Transition> hindsight(int n, Rng& rng) const;
  /// Inner work since construction.
  [[nodiscard]] virtual Work work() const { return {}; }

 protected:
  struct View {
    Eigen::VectorXf observation;
    ActionMask mask = 0;
  };

 private:
  /// First state of an episode.
  virtual View do_reset(Rng rng) = 0;
  /// `x_k`: the clipped parameters of action k.
  virtual Step do_step(int k, std::span<const float> x_k, View& next) = 0;

  Eigen::VectorXf observation_;
  ActionMask mask_ = 0;
  bool running_ = false;
};

}  // namespace modsearch
