#include <modsearch/rl/one_network_values_internal.hpp>

namespace modsearch {

OneNetworkValues::OneNetworkValues(const HybridSpace& space, const Options& options, Rng rng)
    : space_{space},
      n_s_{options.observation_size},
      network_{{.inputs = n_s_ + space.n_parameters(),
                .hidden = options.hidden,
                .outputs = space.n_actions(),
                .leak = options.leak}} {
  network_.initialise({.output_deviation = options.output_deviation}, rng);
}

const Eigen::VectorXf& OneNetworkValues::forward_taken(const RowMatrixXf& s, const RowMatrixXf& x,
                                                       const Eigen::VectorXi& k) {
  check_states(s, x, n_s_, space_);
  check_actions(k, s.rows(), space_);
  taken_ = k;
  seen_x_ = x;
  for (Eigen::Index row = 0; row < k.size(); ++row) hide_others(k[row], seen_x_.data() + row * x.cols());
  const RowMatrixXf& all = network_.forward(s, seen_x_, taken_pass_);
  taken_values_.resize(k.size());
  for (Eigen::Index row = 0; row < k.size(); ++row) taken_values_[row] = all(row, k[row]);
  return taken_values_;
}

void OneNetworkValues::weights_gradient(const Eigen::VectorXf& dq, Eigen::VectorXf& gradient) {
  check_size("slopes", dq.size(), taken_.size());
  taken_slopes_.setZero(dq.size(), space_.n_actions());
  for (Eigen::Index row = 0; row < dq.size(); ++row) taken_slopes_(row, taken_[row]) = dq[row];
  network_.backward(taken_slopes_, taken_pass_, &gradient, nullptr);
}

}  // namespace modsearch
