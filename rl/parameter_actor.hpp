#pragma once

#include <modsearch/rl/adam.hpp>
#include <modsearch/rl/agent.hpp>
#include <modsearch/rl/agent_options.hpp>
#include <modsearch/rl/mlp.hpp>

namespace modsearch {

/// The parameter actor mu(s) of the P-DQN family: a perceptron plus a linear passthrough W s + b (Bester et al. 2019).
/// Theirs is drawn once and never learns; where it does, what is linear in s is learned to the last digit, which the
/// perceptron alone only comes close to. Linear outputs: what becomes of gradients at the bounds keeps them in, not a
/// squash.
class ParameterActor {
 public:
  /// `n_heads`: outputs in front of the D parameters that the passthrough leaves alone (PA-DDPG's K preferences).
  ParameterActor(const HybridSpace& space, int observation_size, int n_heads, const AgentOptions& options, Rng rng);

  /// mu(s) [B x (n_heads + D)].
  const RowMatrixXf& forward(const RowMatrixXf& s);
  /// The same for one state [n_heads + D]: acting.
  [[nodiscard]] Eigen::VectorXf forward_one(const Eigen::VectorXf& s);
  /// Adds dL/dw to `gradient` for dL/dmu at the last forward.
  void backward(const RowMatrixXf& d_outputs, Eigen::VectorXf& gradient);
  /// The same for the passthrough, at the states `s` of that forward.
  void passthrough_backward(const RowMatrixXf& d_outputs, const RowMatrixXf& s, Eigen::VectorXf& gradient) const;

  /// Weights of the perceptron.
  [[nodiscard]] Eigen::VectorXf& parameters() { return network_.parameters(); }
  /// Weights of the passthrough: W [D x observation_size] by columns, then b [D].
  [[nodiscard]] Eigen::VectorXf& passthrough() { return passthrough_; }

 private:
  Mlp network_;
  Mlp::Pass pass_;
  Eigen::VectorXf passthrough_;  // as passthrough() says
  RowMatrixXf outputs_;
  int n_heads_;
  bool has_passthrough_ = false;  // W or b is not 0, or may not stay so
};

/// A parameter actor that learns: mu, its slowly following target mu', and what the learning remembers.
class LearningActor {
 public:
  /// See ParameterActor.
  LearningActor(const HybridSpace& space, int observation_size, int n_heads, const AgentOptions& options, Rng rng);

  ParameterActor mu;
  ParameterActor target;

  /// The one that acts: mu, or mu' where the options ask for its average.
  [[nodiscard]] ParameterActor& acting() { return average_ ? target : mu; }
  /// One step of Adam along dJ/dmu [B x (n_heads + D)] at `outputs`, the last forward of mu, which was at `s`, bent at
  /// the bounds as the options say. `rate_factor` scales the learning rates. Returns the norm of the gradient in the
  /// perceptron's weights before clipping.
  double climb(RowMatrixXf g, const RowMatrixXf& s, const RowMatrixXf& outputs, double rate_factor);
  /// The target follows mu.
  void follow();
  /// Adds its memory to `parts`.
  void append_state(std::vector<StatePart>& parts);

 private:
  BoundGradients bounds_;
  float bound_;
  bool average_;
  float tau_;
  double rate_;
  double passthrough_rate_;
  Adam adam_;
  Adam passthrough_adam_;
  Eigen::VectorXf gradient_;
  Eigen::VectorXf passthrough_gradient_;
};

}  // namespace modsearch
