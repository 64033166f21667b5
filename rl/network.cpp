#include <fmt/format.h>

#include <algorithm>
#include <modsearch/rl/float_kernels_internal.hpp>
#include <modsearch/rl/linear_layer_internal.hpp>
#include <modsearch/rl/network.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

// Up to here the scalar products of rows cost no more than a product padded to 16 columns.
constexpr int kFewOutputs = 8;

std::size_t count(Eigen::Index rows, Eigen::Index stride) { return static_cast<std::size_t>(rows * stride); }

void copy_rows(const RowMatrixXf& from, float* to, Eigen::Index stride) {
  for (Eigen::Index row = 0; row < from.rows(); ++row) {
    std::copy_n(from.data() + row * from.cols(), from.cols(), to + row * stride);
  }
}

void copy_rows(const float* from, Eigen::Index stride, RowMatrixXf& to) {
  for (Eigen::Index row = 0; row < to.rows(); ++row) {
    std::copy_n(from + row * stride, to.cols(), to.data() + row * to.cols());
  }
}

}  // namespace

Network::Network(Shape shape) : shape_{std::move(shape)} {
  if (!(shape_.leak >= 0.0F && shape_.leak < 1.0F)) {
    throw std::invalid_argument(fmt::format("network: leak {}, must be in [0, 1)", shape_.leak));
  }
  std::vector<int> widths{shape_.inputs};
  widths.insert(widths.end(), shape_.hidden.begin(), shape_.hidden.end());
  widths.push_back(shape_.outputs);
  for (const int width : widths) {
    if (width < 1)
      throw std::invalid_argument(fmt::format("network: a layer of width {}, at least 1 is needed", width));
  }
  for (std::size_t l = 0; l + 1 < widths.size(); ++l) {
    LinearLayer layer{.inputs = widths[l], .outputs = widths[l + 1]};
    layer.transposed = l + 2 == widths.size() && layer.outputs <= kFewOutputs;
    layer.row = padded(layer.transposed ? layer.inputs : layer.outputs);
    layer.weights = size_;
    layer.bias = size_ + layer.row * (layer.transposed ? layer.outputs : layer.inputs);
    size_ = layer.bias + padded(layer.outputs);
    layers_.push_back(layer);
  }
}

void Network::prepare(Pass& pass) const {
  if (!pass.activations_.empty() && pass.shape_ == shape_) return;
  pass = Pass{};
  pass.shape_ = shape_;
  pass.activations_.resize(layers_.size());
  pass.transposed_.resize(layers_.size());
}

const RowMatrixXf& Network::forward(const float* w, const RowMatrixXf& inputs, Pass& pass) const {
  return forward(w, inputs, RowMatrixXf(inputs.rows(), 0), pass);
}

const RowMatrixXf& Network::forward(const float* w, const RowMatrixXf& left, const RowMatrixXf& right,
                                    Pass& pass) const {
  if (left.cols() + right.cols() != shape_.inputs || left.rows() != right.rows()) {
    throw std::invalid_argument(fmt::format("network: inputs of {} x {} and {} x {}, rows of {} are needed",
                                            left.rows(), left.cols(), right.rows(), right.cols(), shape_.inputs));
  }
  prepare(pass);
  pass.rows_ = left.rows();
  const Eigen::Index stride = padded(shape_.inputs);
  FloatBuffer& inputs = pass.activations_.front();
  inputs.resize(count(pass.rows_, stride));
  copy_rows(left, inputs.data(), stride);
  if (right.cols() > 0) copy_rows(right, inputs.data() + left.cols(), stride);
  return run(w, pass);
}

const RowMatrixXf& Network::run(const float* w, Pass& pass) const {
  pass.outputs_.resize(pass.rows_, shape_.outputs);
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const LinearLayer& layer = layers_[l];
    const ConstRows x{pass.activations_[l].data(), padded(layer.inputs)};
    if (layer.transposed) {
      modsearch::forward(layer, w, pass.rows_, x, {pass.outputs_.data(), layer.outputs}, std::nullopt);
      break;
    }
    const bool last = l + 1 == layers_.size();
    const Eigen::Index stride = padded(layer.outputs);
    FloatBuffer& y = last ? pass.padded_outputs_ : pass.activations_[l + 1];
    y.resize(count(pass.rows_, stride));
    modsearch::forward(layer, w, pass.rows_, x, {y.data(), stride}, last ? std::nullopt : std::optional{shape_.leak});
    if (last) copy_rows(y.data(), stride, pass.outputs_);
  }
  return pass.outputs_;
}

const Eigen::VectorXf& Network::forward_one(const float* w, const Eigen::VectorXf& input, Pass& pass) const {
  if (input.size() != shape_.inputs) {
    throw std::invalid_argument(fmt::format("network: {} inputs, {} are needed", input.size(), shape_.inputs));
  }
  prepare(pass);
  pass.single_outputs_.resize(shape_.outputs);
  const float* x = input.data();
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const LinearLayer& layer = layers_[l];
    if (layer.transposed) {
      if (l == 0) {  // reads whole vectors
        FloatBuffer& whole = pass.single_[0];
        whole.assign(count(1, padded(layer.inputs)), 0.0F);
        std::copy_n(x, layer.inputs, whole.data());
        x = whole.data();
      }
      modsearch::forward(layer, w, 1, {x, 0}, {pass.single_outputs_.data(), 0}, std::nullopt);
      break;
    }
    const bool last = l + 1 == layers_.size();
    FloatBuffer& y = pass.single_[l % 2];
    y.resize(std::max(y.size(), count(1, padded(layer.outputs))));
    modsearch::forward(layer, w, 1, {x, 0}, {y.data(), 0}, last ? std::nullopt : std::optional{shape_.leak});
    x = y.data();
    if (last) std::copy_n(x, layer.outputs, pass.single_outputs_.data());
  }
  return pass.single_outputs_;
}

void Network::backward(const float* w, const RowMatrixXf& d_outputs, Pass& pass, float* gradient, RowMatrixXf* d_inputs,
                       int first_input) const {
  if (pass.rows_ < 0 || pass.shape_ != shape_ || d_outputs.rows() != pass.rows_ || d_outputs.cols() != shape_.outputs) {
    throw std::invalid_argument(fmt::format("network: slopes of {} x {} outputs, the forward pass had {} x {}",
                                            d_outputs.rows(), d_outputs.cols(), pass.rows_, shape_.outputs));
  }
  if (first_input < 0 || first_input > shape_.inputs) {
    throw std::invalid_argument(
        fmt::format("network: slopes from input {}, not in [0, {}]", first_input, shape_.inputs));
  }
  ConstRows dy{d_outputs.data(), d_outputs.cols()};
  if (!layers_.back().transposed) {
    FloatBuffer& whole = pass.slopes_[layers_.size() % 2];
    const Eigen::Index stride = padded(shape_.outputs);
    whole.assign(count(pass.rows_, stride), 0.0F);
    copy_rows(d_outputs, whole.data(), stride);
    dy = {whole.data(), stride};
  }
  for (std::size_t l = layers_.size(); l-- > 0;) {
    const LinearLayer& layer = layers_[l];
    const ConstRows x{pass.activations_[l].data(), padded(layer.inputs)};
    if (gradient) add_weights_gradient(layer, pass.rows_, x, dy, gradient);
    if (l == 0) break;
    FloatBuffer& dx = pass.slopes_[l % 2];
    dx.resize(std::max(dx.size(), count(pass.rows_, x.stride)));
    inputs_gradient(layer, w, pass.rows_, dy, x, shape_.leak, {dx.data(), x.stride}, pass.transposed_[l]);
    dy = {dx.data(), x.stride};
  }
  if (!d_inputs) return;
  const LinearLayer& first = layers_.front();
  d_inputs->resize(pass.rows_, shape_.inputs - first_input);
  if (first.transposed) {
    using Columns = Eigen::Map<const RowMatrixXf, Eigen::Unaligned, Eigen::OuterStride<>>;
    const Columns columns{w + first.weights, first.outputs, first.inputs, Eigen::OuterStride<>{first.row}};
    d_inputs->noalias() = d_outputs * columns.rightCols(d_inputs->cols());
    return;
  }
  float_kernels().row_dots({.rows = pass.rows_,
                            .columns = d_inputs->cols(),
                            .depth = first.outputs,
                            .a = dy.data,
                            .a_row = dy.stride,
                            .b = w + first.weights + first_input * first.row,
                            .b_row = first.row,
                            .c = d_inputs->data(),
                            .c_row = d_inputs->cols()});
}

}  // namespace modsearch
