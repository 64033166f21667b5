#pragma once

#include <memory>
#include <modsearch/problem/rng.hpp>
#include <modsearch/rl/hybrid_space.hpp>
#include <vector>

namespace modsearch {

/// How the value network reads the parameters of the actions: what tells P-DQN, MP-DQN and SP-DQN apart.
enum class ValueKind {
  kJoint,      ///< P-DQN (Xiong et al. 2018): one pass on [s; x_1 .. x_K]
  kMultiPass,  ///< MP-DQN (Bester et al. 2019): the same network, K passes, all of x but x_k zero in pass k
  kSeparate,   ///< SP-DQN (Bester et al. 2019): K networks on [s; x_k]
};

/// Q(s, x) in R^K with its gradients: the value network of the P-DQN family. With its workspace: parameters_gradient()
/// refers to the last forward(), weights_gradient() to the last forward_taken(), and what these functions return lives
/// until the same function is called again. Between a forward and its gradient the weights must not change.
///
/// All throw std::invalid_argument for matrices of other sizes than promised, std::logic_error for a gradient without
/// its forward.
class ActionValues {
 public:
  struct Options {
    int observation_size = 0;        ///< length of s
    std::vector<int> hidden{128};    ///< widths of the hidden layers. Bester et al. 2019
    float leak = 0.0F;               ///< slope of the leaky ReLU below zero; 0: plain ReLU, as in the papers
    float output_deviation = -1.0F;  ///< see Mlp::Init
  };
  virtual ~ActionValues() = default;
  /// An independent copy: a target network, for instance.
  [[nodiscard]] virtual std::unique_ptr<ActionValues> clone() const = 0;

  [[nodiscard]] virtual ValueKind kind() const = 0;
  /// All weights of all networks, padding included (which is and stays 0).
  [[nodiscard]] virtual Eigen::VectorXf& parameters() = 0;
  [[nodiscard]] virtual const Eigen::VectorXf& parameters() const = 0;

  /// Q [B x K] for states s [B x observation_size] and parameters of all actions x [B x D].
  virtual const RowMatrixXf& forward(const RowMatrixXf& s, const RowMatrixXf& x) = 0;
  /// dL/dx [B x D] for dL/dQ [B x K] at the last forward(). MP-DQN, SP-DQN: Q_k does not depend on x_j, j != k, at all.
  virtual const RowMatrixXf& parameters_gradient(const RowMatrixXf& dq) = 0;

  /// Q_k(s, x) [B] of one action per row only, k [B]: MP-DQN needs a single pass for it, SP-DQN a single network.
  virtual const Eigen::VectorXf& forward_taken(const RowMatrixXf& s, const RowMatrixXf& x,
                                               const Eigen::VectorXi& k) = 0;
  /// Adds dL/dw to `gradient` (the size of parameters()) for dL/dQ_k [B] at the last forward_taken().
  virtual void weights_gradient(const Eigen::VectorXf& dq, Eigen::VectorXf& gradient) = 0;

  /// Q [K] at one s [observation_size], x [D], at the least cost: for acting. Leaves the other workspaces alone.
  virtual const Eigen::VectorXf& forward_one(const Eigen::VectorXf& s, const Eigen::VectorXf& x) = 0;
};

/// Throws std::invalid_argument unless every width and observation_size is at least 1.
[[nodiscard]] std::unique_ptr<ActionValues> make_action_values(ValueKind kind, const HybridSpace& space,
                                                               const ActionValues::Options& options, Rng rng);

}  // namespace modsearch
