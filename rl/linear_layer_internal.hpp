#pragma once

#include <modsearch/rl/network.hpp>
#include <optional>

namespace modsearch {

/// Rows of numbers, `stride` apart.
struct Rows {
  float* data = nullptr;
  Eigen::Index stride = 0;
};
struct ConstRows {
  const float* data = nullptr;
  Eigen::Index stride = 0;
};

/// y = x W + b for `rows` rows, followed by a leaky ReLU if `leak` is given.
/// x of a transposed layer and y of any other are padded.
void forward(const LinearLayer& layer, const float* w, Eigen::Index rows, ConstRows x, Rows y,
             std::optional<float> leak);

/// gradient += dL/dW, dL/db for dL/dy. x of a transposed layer and dy of any other are padded.
void add_weights_gradient(const LinearLayer& layer, Eigen::Index rows, ConstRows x, ConstRows dy, float* gradient);

/// dL/dx [padded] for dL/dy, times the slope of the leaky ReLU whose output x was. `transposed` is scratch for this
/// layer alone (its padding has to stay 0).
void inputs_gradient(const LinearLayer& layer, const float* w, Eigen::Index rows, ConstRows dy, ConstRows x, float leak,
                     Rows dx, FloatBuffer& transposed);

/// The columns of W, one after the other: W^T [outputs x padded inputs], in `scratch` unless it is stored so.
[[nodiscard]] ConstRows columns(const LinearLayer& layer, const float* w, FloatBuffer& scratch);

}  // namespace modsearch
