#pragma once

#include <memory>
#include <modsearch/rl/mlp.hpp>

namespace modsearch {

/// How the value network reads the parameters of the actions: what tells P-DQN, MP-DQN and SP-DQN apart.
enum class ValueKind {
  kJoint,      ///< P-DQN (Xiong et al. 2018): one pass on [s; x_1 .. x_K]
  kMultiPass,  ///< MP-DQN (Bester et al. 2019): the same network, K passes, all of x but x_k zero in pass k
  kSeparate,   ///< SP-DQN (Bester et al. 2019): K networks on [s; x_k]
};

/// Q(s, x) in R^K with its gradients: the value network of the P-DQN family. A workspace: the backward functions refer to
/// the last forward of the same kind.
class ActionValues {
 public:
  struct Options {
    int observation_size = 0;
    std::vector<int> hidden{128};
    float leak = 0.0F;
    float output_deviation = -1.0F;  ///< see Mlp::Init
  };
  virtual ~ActionValues() = default;

  [[nodiscard]] virtual Eigen::VectorXf& parameters() = 0;

  /// Q [B x K] for states s [B x observation_size] and parameters of all actions x [B x D].
  virtual const RowMatrixXf& forward(const RowMatrixXf& s, const RowMatrixXf& x) = 0;
  /// dL/dx [B x D] for dL/dQ [B x K] at the last forward().
  virtual const RowMatrixXf& parameters_gradient(const RowMatrixXf& dq) = 0;

  /// Q_k(s, x) [B] of one action per row only, k [B]: MP-DQN needs a single pass for it.
  virtual const Eigen::VectorXf& forward_taken(const RowMatrixXf& s, const RowMatrixXf& x, const Eigen::VectorXi& k) = 0;
  /// Adds dL/dw to `gradient` (the size of parameters()) for dL/dQ_k [B] at the last forward_taken().
  virtual void weights_gradient(const Eigen::VectorXf& dq, Eigen::VectorXf& gradient) = 0;
};

[[nodiscard]] std::unique_ptr<ActionValues> make_action_values(ValueKind kind, const HybridSpace& space,
                                                               const ActionValues::Options& options, Rng rng);

}  // namespace modsearch
