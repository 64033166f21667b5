#include <fmt/format.h>

#include <cmath>
#include <modsearch/rl/mlp.hpp>
#include <stdexcept>

namespace modsearch {

Mlp::Mlp(Shape shape) : network_{std::move(shape)}, parameters_{Eigen::VectorXf::Zero(network_.size())} {}

void Mlp::initialise(Init init, Rng& rng) { parameters_ = draw_weights(network_, init, rng); }

Mlp::Weights Mlp::weights(const Network& network, float* w, int l) {
  const LinearLayer& layer = network.layers()[static_cast<std::size_t>(l)];
  using Stride = Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>;
  const Stride stride = layer.transposed ? Stride{1, layer.row} : Stride{layer.row, 1};
  return {w + layer.weights, layer.inputs, layer.outputs, stride};
}

Mlp::Bias Mlp::bias(const Network& network, float* w, int l) {
  const LinearLayer& layer = network.layers()[static_cast<std::size_t>(l)];
  return {w + layer.bias, layer.outputs};
}

// Views that are read only by their type.
Mlp::ConstWeights Mlp::weights(int l) const {
  const Weights view = weights(network_, const_cast<float*>(parameters_.data()), l);
  return {view.data(), view.rows(), view.cols(), {view.outerStride(), view.innerStride()}};
}

Mlp::ConstBias Mlp::bias(int l) const {
  const Bias view = bias(network_, const_cast<float*>(parameters_.data()), l);
  return {view.data(), view.size()};
}

void Mlp::backward(const RowMatrixXf& d_outputs, Pass& pass, Eigen::VectorXf* gradient, RowMatrixXf* d_inputs,
                   int first_input) const {
  if (gradient && gradient->size() != parameters_.size()) {
    throw std::invalid_argument(
        fmt::format("network: a gradient of {} numbers, {} are needed", gradient->size(), parameters_.size()));
  }
  network_.backward(parameters_.data(), d_outputs, pass, gradient ? gradient->data() : nullptr, d_inputs, first_input);
}

Eigen::VectorXf draw_weights(const Network& network, Mlp::Init init, Rng& rng) {
  Eigen::VectorXf result = Eigen::VectorXf::Zero(network.size());
  const auto n_layers = static_cast<int>(network.layers().size());
  for (int l = 0; l < n_layers; ++l) {
    Mlp::Weights w = Mlp::weights(network, result.data(), l);
    const double fan_in = static_cast<double>(w.rows());
    const double deviation = l + 1 == n_layers ? static_cast<double>(init.output_deviation) : std::sqrt(2.0 / fan_in);
    const double bound = 1.0 / std::sqrt(fan_in);
    for (Eigen::Index i = 0; i < w.rows(); ++i) {
      for (Eigen::Index j = 0; j < w.cols(); ++j) {
        w(i, j) = static_cast<float>(deviation < 0.0 ? rng.uniform(-bound, bound) : deviation * rng.normal());
      }
    }
  }
  return result;
}

}  // namespace modsearch
