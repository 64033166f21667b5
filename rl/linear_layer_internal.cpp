#include <modsearch/rl/float_kernels_internal.hpp>
#include <modsearch/rl/linear_layer_internal.hpp>

namespace modsearch {

void forward(const LinearLayer& layer, const float* w, Eigen::Index rows, ConstRows x, Rows y,
             std::optional<float> leak) {
  if (layer.transposed) {
    float_kernels().row_dots({.rows = rows,
                              .columns = layer.outputs,
                              .depth = layer.inputs,
                              .a = x.data,
                              .a_row = x.stride,
                              .b = w + layer.weights,
                              .b_row = layer.row,
                              .c = y.data,
                              .c_row = y.stride,
                              .bias = w + layer.bias});
    return;
  }
  float_kernels().multiply({.rows = rows,
                            .columns = layer.outputs,
                            .depth = layer.inputs,
                            .a = x.data,
                            .a_row = x.stride,
                            .b = w + layer.weights,
                            .b_row = layer.row,
                            .c = y.data,
                            .c_row = y.stride,
                            .bias = w + layer.bias,
                            .leak = leak.value_or(0.0F),
                            .rectify = leak.has_value()});
}

void add_weights_gradient(const LinearLayer& layer, Eigen::Index rows, ConstRows x, ConstRows dy, float* gradient) {
  // dW = x^T dy, or dW^T = dy^T x: the wider of the two is read as vectors.
  const ConstRows& left = layer.transposed ? dy : x;
  const ConstRows& right = layer.transposed ? x : dy;
  float_kernels().multiply({.rows = layer.transposed ? layer.outputs : layer.inputs,
                            .columns = layer.transposed ? layer.inputs : layer.outputs,
                            .depth = rows,
                            .a = left.data,
                            .a_row = 1,
                            .a_column = left.stride,
                            .b = right.data,
                            .b_row = right.stride,
                            .c = gradient + layer.weights,
                            .c_row = layer.row,
                            .initial = gradient + layer.weights,
                            .initial_row = layer.row});
  if (!layer.transposed) {
    float_kernels().add_column_sums(rows, layer.outputs, dy.data, dy.stride, gradient + layer.bias);
    return;
  }
  for (Eigen::Index j = 0; j < layer.outputs; ++j) {
    float sum = 0.0F;
    for (Eigen::Index row = 0; row < rows; ++row) sum += dy.data[row * dy.stride + j];
    gradient[layer.bias + j] += sum;
  }
}

ConstRows columns(const LinearLayer& layer, const float* w, FloatBuffer& scratch) {
  if (layer.transposed) return {w + layer.weights, layer.row};
  const Eigen::Index stride = padded(layer.inputs);
  scratch.resize(static_cast<std::size_t>(layer.outputs * stride));
  float_kernels().transpose(layer.inputs, layer.outputs, w + layer.weights, layer.row, scratch.data(), stride);
  return {scratch.data(), stride};
}

void inputs_gradient(const LinearLayer& layer, const float* w, Eigen::Index rows, ConstRows dy, ConstRows x, float leak,
                     Rows dx, FloatBuffer& transposed) {
  const ConstRows b = columns(layer, w, transposed);
  float_kernels().multiply({.rows = rows,
                            .columns = layer.inputs,
                            .depth = layer.outputs,
                            .a = dy.data,
                            .a_row = dy.stride,
                            .b = b.data,
                            .b_row = b.stride,
                            .c = dx.data,
                            .c_row = dx.stride,
                            .mask = x.data,
                            .mask_row = x.stride,
                            .leak = leak});
}

}  // namespace modsearch
