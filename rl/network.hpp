#pragma once

#include <modsearch/rl/float_buffer.hpp>
#include <modsearch/rl/hybrid_space.hpp>
#include <vector>

namespace modsearch {

/// Where one linear layer y = x W + b lies in a network's weights, in floats. Rows are padded to whole vectors with
/// zeros.
struct LinearLayer {
  Eigen::Index inputs = 0, outputs = 0;
  /// A last layer of few outputs is stored as W^T [outputs x padded inputs], and its products are scalar products of
  /// rows; all others as W [inputs x padded outputs].
  bool transposed = false;
  Eigen::Index row = 0;      ///< from one row of W (W^T) to the next
  Eigen::Index weights = 0;  ///< first number of W (W^T)
  Eigen::Index bias = 0;     ///< first number of b
};

/// A multi-layer perceptron as a function of its weights: linear layers with (leaky) ReLU between them, the last one
/// linear. Without weights of its own, so that several networks can share one vector of them; see Mlp for the usual
/// case.
///
/// Runs in float kernels chosen at run time for the processor (see kernel_isa). Equal inputs give equal bits on one
/// instruction set, and the outputs of a row do not depend on the other rows.
class Network {
 public:
  struct Shape {
    int inputs = 0;
    std::vector<int> hidden;  ///< widths of the hidden layers; may be empty
    int outputs = 0;
    float leak = 0.0F;  ///< slope of the leaky ReLU below zero; 0: plain ReLU

    friend bool operator==(const Shape&, const Shape&) = default;
  };

  /// Memory of one forward pass, kept by the caller so that nothing is allocated in a loop. backward() needs the Pass
  /// of the forward() it belongs to.
  class Pass {
    friend class Network;
    Shape shape_;                           // for which the memory below was laid out
    Eigen::Index rows_ = -1;                // B; negative: no forward pass yet
    std::vector<FloatBuffer> activations_;  // [n_layers] inputs of each layer [B x padded]
    FloatBuffer padded_outputs_;            // [B x padded], where the last layer is not transposed
    RowMatrixXf outputs_;                   // [B x outputs]
    FloatBuffer single_[2];                 // forward_one: inputs and outputs of a layer, by turns
    Eigen::VectorXf single_outputs_;
    FloatBuffer slopes_[2];                // backward: dL/d outputs and inputs of a layer, by turns
    std::vector<FloatBuffer> transposed_;  // [n_layers] W^T
  };

  /// Throws std::invalid_argument unless every width is at least 1 and the leak is in [0, 1).
  explicit Network(Shape shape);

  [[nodiscard]] const Shape& shape() const { return shape_; }
  [[nodiscard]] const std::vector<LinearLayer>& layers() const { return layers_; }
  /// Number of weights, padding included.
  [[nodiscard]] Eigen::Index size() const { return size_; }

  /// Outputs [B x outputs] for inputs [B x inputs] under the weights `w` [size()]; they live in `pass`.
  /// Throws std::invalid_argument for another number of inputs.
  const RowMatrixXf& forward(const float* w, const RowMatrixXf& inputs, Pass& pass) const;
  /// The same for inputs in two parts side by side.
  const RowMatrixXf& forward(const float* w, const RowMatrixXf& left, const RowMatrixXf& right, Pass& pass) const;
  /// Outputs [outputs] for one input [inputs], at the least cost. Leaves what backward() needs alone.
  const Eigen::VectorXf& forward_one(const float* w, const Eigen::VectorXf& input, Pass& pass) const;
  /// Gradients of a loss L from dL/d outputs [B x outputs] at the forward() that wrote `pass`, under the same weights:
  /// adds dL/dw to `gradient` [size()], writes dL/d inputs from number `first_input` on, [B x (inputs - first_input)],
  /// to
  /// `*d_inputs`. Null: not wanted. Throws std::invalid_argument for sizes other than those of the forward pass.
  void backward(const float* w, const RowMatrixXf& d_outputs, Pass& pass, float* gradient, RowMatrixXf* d_inputs,
                int first_input = 0) const;

 private:
  void prepare(Pass& pass) const;
  const RowMatrixXf& run(const float* w, Pass& pass) const;

  Shape shape_;
  std::vector<LinearLayer> layers_;
  Eigen::Index size_ = 0;
};

}  // namespace modsearch
