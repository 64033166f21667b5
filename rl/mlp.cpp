#include <modsearch/rl/mlp.hpp>

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace modsearch {

Mlp::Mlp(Shape shape) : shape_{std::move(shape)} {
  std::vector<int> widths{shape_.inputs};
  widths.insert(widths.end(), shape_.hidden.begin(), shape_.hidden.end());
  widths.push_back(shape_.outputs);
  for (const int width : widths) {
    if (width < 1) throw std::invalid_argument(fmt::format("network: a layer of width {}, at least 1 is needed", width));
  }
  Eigen::Index place = 0;
  for (std::size_t l = 0; l + 1 < widths.size(); ++l) {
    const Layer layer{widths[l], widths[l + 1], place, place + widths[l] * widths[l + 1]};
    place = layer.bias + layer.outputs;
    layers_.push_back(layer);
  }
  parameters_.setZero(place);
}

void Mlp::initialise(Init init, Rng& rng) {
  parameters_.setZero();
  for (int l = 0; l < n_layers(); ++l) {
    Weights w = weights(l);
    const double fan_in = static_cast<double>(w.rows());
    const bool last = l + 1 == n_layers();
    const double deviation = last ? static_cast<double>(init.output_deviation) : std::sqrt(2.0 / fan_in);
    const double bound = 1.0 / std::sqrt(fan_in);
    for (Eigen::Index i = 0; i < w.rows(); ++i) {
      for (Eigen::Index j = 0; j < w.cols(); ++j) {
        w(i, j) = static_cast<float>(deviation < 0.0 ? rng.uniform(-bound, bound) : deviation * rng.normal());
      }
    }
  }
}

Mlp::Weights Mlp::weights(int l) {
  const Layer& layer = layers_[static_cast<std::size_t>(l)];
  return {parameters_.data() + layer.weights, layer.inputs, layer.outputs, Eigen::OuterStride<>{layer.outputs}};
}

Mlp::ConstWeights Mlp::weights(int l) const {
  const Layer& layer = layers_[static_cast<std::size_t>(l)];
  return {parameters_.data() + layer.weights, layer.inputs, layer.outputs, Eigen::OuterStride<>{layer.outputs}};
}

Mlp::Bias Mlp::bias(int l) {
  const Layer& layer = layers_[static_cast<std::size_t>(l)];
  return {parameters_.data() + layer.bias, layer.outputs};
}

Mlp::ConstBias Mlp::bias(int l) const {
  const Layer& layer = layers_[static_cast<std::size_t>(l)];
  return {parameters_.data() + layer.bias, layer.outputs};
}

const RowMatrixXf& Mlp::forward(const RowMatrixXf& inputs, Pass& pass) const {
  if (inputs.cols() != shape_.inputs) {
    throw std::invalid_argument(
        fmt::format("network: {} inputs given, {} are needed", inputs.cols(), shape_.inputs));
  }
  pass.activations_.resize(layers_.size());
  pass.activations_[0] = inputs;
  for (int l = 0; l < n_layers(); ++l) {
    const bool last = l + 1 == n_layers();
    RowMatrixXf& y = last ? pass.outputs_ : pass.activations_[static_cast<std::size_t>(l) + 1];
    y.noalias() = pass.activations_[static_cast<std::size_t>(l)] * weights(l);
    y.rowwise() += bias(l).transpose();
    if (!last) y = y.cwiseMax(shape_.leak * y);
  }
  return pass.outputs_;
}

const Eigen::VectorXf& Mlp::forward_one(const Eigen::VectorXf& input, Pass& pass) const {
  const RowMatrixXf row = input.transpose();
  pass.single_ = forward(row, pass).row(0);
  return pass.single_;
}

void Mlp::backward(const RowMatrixXf& d_outputs, Pass& pass, Eigen::VectorXf* gradient, RowMatrixXf* d_inputs) const {
  if (pass.activations_.size() != layers_.size() || d_outputs.rows() != pass.outputs_.rows() ||
      d_outputs.cols() != shape_.outputs) {
    throw std::invalid_argument(fmt::format("network: gradient of {} x {} outputs, the forward pass had {} x {}",
                                            d_outputs.rows(), d_outputs.cols(), pass.outputs_.rows(), shape_.outputs));
  }
  if (gradient && gradient->size() != parameters_.size()) {
    throw std::invalid_argument(fmt::format("network: a gradient of {} numbers, {} are needed", gradient->size(),
                                            parameters_.size()));
  }
  pass.slope_ = d_outputs;
  for (int l = n_layers() - 1; l >= 0; --l) {
    const Layer& layer = layers_[static_cast<std::size_t>(l)];
    const RowMatrixXf& x = pass.activations_[static_cast<std::size_t>(l)];
    if (gradient) {
      Weights{gradient->data() + layer.weights, layer.inputs, layer.outputs, Eigen::OuterStride<>{layer.outputs}}
          .noalias() += x.transpose() * pass.slope_;
      Bias{gradient->data() + layer.bias, layer.outputs} += pass.slope_.colwise().sum().transpose();
    }
    if (l == 0) {
      if (d_inputs) d_inputs->noalias() = pass.slope_ * weights(0).transpose();
      return;
    }
    pass.slope_below_.noalias() = pass.slope_ * weights(l).transpose();
    // An activation has the sign of what went into it (leak >= 0).
    pass.slope_ = (x.array() > 0.0F).select(pass.slope_below_, shape_.leak * pass.slope_below_);
  }
}

}  // namespace modsearch
