#pragma once

#include <modsearch/problem/rng.hpp>
#include <modsearch/rl/hybrid_space.hpp>
#include <vector>

namespace modsearch {

/// A multi-layer perceptron: linear layers with (leaky) ReLU between them, the last one linear. All weights live in one
/// vector, so that an optimiser or a soft update is one loop over it.
///
/// A value: a copy is an independent network (a target network, for instance).
class Mlp {
 public:
  struct Shape {
    int inputs = 0;
    std::vector<int> hidden;  ///< widths of the hidden layers; may be empty
    int outputs = 0;
    float leak = 0.0F;  ///< slope of the leaky ReLU below zero; 0: plain ReLU

    friend bool operator==(const Shape&, const Shape&) = default;
  };
  /// How the weights of the last layer are drawn. Hidden layers: He et al. 2015, N(0, 2 / fan_in). Biases 0.
  struct Init {
    /// Standard deviation of the last layer's weights; negative: uniform in +-1 / sqrt(fan_in); 0: zeros.
    float output_deviation = -1.0F;
  };
  using Weights = Eigen::Map<RowMatrixXf, Eigen::Unaligned, Eigen::OuterStride<>>;
  using ConstWeights = Eigen::Map<const RowMatrixXf, Eigen::Unaligned, Eigen::OuterStride<>>;
  using Bias = Eigen::Map<Eigen::VectorXf>;
  using ConstBias = Eigen::Map<const Eigen::VectorXf>;

  /// Memory of one forward pass, kept by the caller so that nothing is allocated in a loop. backward() needs the Pass of
  /// the forward() it belongs to.
  class Pass {
    friend class Mlp;
    std::vector<RowMatrixXf> activations_;  // [n_layers] inputs of each layer [B x in]
    RowMatrixXf outputs_;                   // [B x outputs]
    Eigen::VectorXf single_;                // of forward_one [outputs]
    RowMatrixXf slope_, slope_below_;       // backward: of one layer's outputs, of its inputs
  };

  /// Weights 0. Throws std::invalid_argument unless every width is at least 1.
  explicit Mlp(Shape shape);
  /// Draws the weights.
  void initialise(Init init, Rng& rng);

  [[nodiscard]] const Shape& shape() const { return shape_; }
  [[nodiscard]] int n_layers() const { return static_cast<int>(shape_.hidden.size()) + 1; }
  /// Everything there is to learn, padding included (which is and stays 0).
  [[nodiscard]] Eigen::VectorXf& parameters() { return parameters_; }
  [[nodiscard]] const Eigen::VectorXf& parameters() const { return parameters_; }
  /// Layer l in 0 .. n_layers() - 1 as y = x W + b: W [in x out], b [out], views of parameters().
  [[nodiscard]] Weights weights(int l);
  [[nodiscard]] ConstWeights weights(int l) const;
  [[nodiscard]] Bias bias(int l);
  [[nodiscard]] ConstBias bias(int l) const;

  /// Outputs [B x outputs] for inputs [B x inputs]; they live in `pass`.
  /// Throws std::invalid_argument for another number of inputs.
  const RowMatrixXf& forward(const RowMatrixXf& inputs, Pass& pass) const;
  /// Outputs [outputs] for one input [inputs], at the least cost; no backward() afterwards.
  const Eigen::VectorXf& forward_one(const Eigen::VectorXf& input, Pass& pass) const;
  /// Gradients of a loss L from dL/d outputs [B x outputs] at the forward() that wrote `pass`: adds dL/d parameters to
  /// `*gradient` (the size of parameters()), writes dL/d inputs [B x inputs] to `*d_inputs`. Null: not wanted.
  /// Throws std::invalid_argument for sizes other than those of the forward pass.
  void backward(const RowMatrixXf& d_outputs, Pass& pass, Eigen::VectorXf* gradient, RowMatrixXf* d_inputs) const;

 private:
  struct Layer {
    Eigen::Index inputs, outputs, weights, bias;  // sizes; places in parameters_
  };

  Shape shape_;
  std::vector<Layer> layers_;
  Eigen::VectorXf parameters_;
};

}  // namespace modsearch
