#pragma once

#include <modsearch/problem/rng.hpp>
#include <modsearch/rl/network.hpp>

namespace modsearch {

/// A multi-layer perceptron with its weights. All of them live in one vector, so that an optimiser or a soft update is
/// one loop over it. A value: a copy is an independent network (a target network, for instance).
class Mlp {
 public:
  using Shape = Network::Shape;
  using Pass = Network::Pass;
  /// How the weights of the last layer are drawn. Hidden layers: He et al. 2015, N(0, 2 / fan_in). Biases 0.
  struct Init {
    /// Standard deviation of the last layer's weights; negative: uniform in +-1 / sqrt(fan_in); 0: zeros.
    float output_deviation = -1.0F;
  };
  using Weights = Eigen::Map<RowMatrixXf, Eigen::Unaligned, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;
  using ConstWeights = Eigen::Map<const RowMatrixXf, Eigen::Unaligned, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;
  using Bias = Eigen::Map<Eigen::VectorXf>;
  using ConstBias = Eigen::Map<const Eigen::VectorXf>;

  /// Weights 0. Throws std::invalid_argument unless every width is at least 1 and the leak is in [0, 1).
  explicit Mlp(Shape shape);
  /// Draws the weights.
  void initialise(Init init, Rng& rng);

  [[nodiscard]] const Shape& shape() const { return network_.shape(); }
  [[nodiscard]] int n_layers() const { return static_cast<int>(network_.layers().size()); }
  /// Everything there is to learn, padding included (which is and stays 0).
  [[nodiscard]] Eigen::VectorXf& parameters() { return parameters_; }
  [[nodiscard]] const Eigen::VectorXf& parameters() const { return parameters_; }
  /// Layer l in 0 .. n_layers() - 1 as y = x W + b: W [in x out], b [out], views of parameters().
  [[nodiscard]] Weights weights(int l) { return weights(network_, parameters_.data(), l); }
  [[nodiscard]] ConstWeights weights(int l) const;
  [[nodiscard]] Bias bias(int l) { return bias(network_, parameters_.data(), l); }
  [[nodiscard]] ConstBias bias(int l) const;
  /// The same views of weights that belong to `network` and lie elsewhere.
  [[nodiscard]] static Weights weights(const Network& network, float* w, int l);
  [[nodiscard]] static Bias bias(const Network& network, float* w, int l);

  /// Outputs [B x outputs] for inputs [B x inputs]; they live in `pass`.
  /// Throws std::invalid_argument for another number of inputs.
  const RowMatrixXf& forward(const RowMatrixXf& inputs, Pass& pass) const {
    return network_.forward(parameters_.data(), inputs, pass);
  }
  /// The same for inputs in two parts side by side.
  const RowMatrixXf& forward(const RowMatrixXf& left, const RowMatrixXf& right, Pass& pass) const {
    return network_.forward(parameters_.data(), left, right, pass);
  }
  /// Outputs [outputs] for one input [inputs], at the least cost. Leaves what backward() needs alone.
  const Eigen::VectorXf& forward_one(const Eigen::VectorXf& input, Pass& pass) const {
    return network_.forward_one(parameters_.data(), input, pass);
  }
  /// Gradients of a loss L from dL/d outputs [B x outputs] at the forward() that wrote `pass`: adds dL/d parameters to
  /// `*gradient` (the size of parameters()), writes dL/d inputs from number `first_input` on to `*d_inputs`
  /// [B x (inputs - first_input)]. Null: not wanted.
  /// Throws std::invalid_argument for sizes other than those of the forward pass.
  void backward(const RowMatrixXf& d_outputs, Pass& pass, Eigen::VectorXf* gradient, RowMatrixXf* d_inputs,
                int first_input = 0) const;

 private:
  Network network_;
  Eigen::VectorXf parameters_;
};

/// Weights of `network` drawn as Mlp::initialise draws them, padding 0 [network.size()].
[[nodiscard]] Eigen::VectorXf draw_weights(const Network& network, Mlp::Init init, Rng& rng);

}  // namespace modsearch
