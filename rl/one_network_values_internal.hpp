#pragma once

#include <modsearch/rl/action_values_internal.hpp>
#include <modsearch/rl/mlp.hpp>

namespace modsearch {

/// What P-DQN and MP-DQN share: one network [s; x] -> R^K, and how it learns from the actions taken.
class OneNetworkValues : public ActionValues {
 public:
  Eigen::VectorXf& parameters() final { return network_.parameters(); }
  const Eigen::VectorXf& parameters() const final { return network_.parameters(); }
  const Eigen::VectorXf& forward_taken(const RowMatrixXf& s, const RowMatrixXf& x, const Eigen::VectorXi& k) final;
  void weights_gradient(const Eigen::VectorXf& dq, Eigen::VectorXf& gradient) final;

 protected:
  OneNetworkValues(const HybridSpace& space, const Options& options, Rng rng);
  OneNetworkValues(const OneNetworkValues&) = default;
  [[nodiscard]] int n_s() const { return n_s_; }
  [[nodiscard]] const HybridSpace& space() const { return space_; }
  [[nodiscard]] const Mlp& network() const { return network_; }

 private:
  /// Zeroes what Q_k does not read of the row of all parameters x [D].
  virtual void hide_others(int k, float* x) const = 0;

  HybridSpace space_;
  int n_s_;
  Mlp network_;
  Mlp::Pass taken_pass_;
  RowMatrixXf seen_x_;
  Eigen::VectorXi taken_;
  Eigen::VectorXf taken_values_;
  RowMatrixXf taken_slopes_;
};

}  // namespace modsearch
