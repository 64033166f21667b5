#pragma once

#include <modsearch/problem/rng.hpp>
#include <modsearch/rl/hybrid_space.hpp>
#include <vector>

namespace modsearch {

/// A multi-layer perceptron: linear layers with (leaky) ReLU between them, the last one linear. All weights live in one
/// vector, so that an optimiser or a soft update is one loop over it.
///
/// Products run in float kernels chosen at run time for the processor (see kernels). Equal inputs give equal bits on one
/// instruction set.
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

  /// Memory of one forward pass, kept by the caller so that nothing is allocated in a loop; backward needs it.
  struct Pass;  // defined below; opaque to users

  /// Weights 0. Throws std::invalid_argument unless every width is at least 1.
  explicit Mlp(Shape shape);
  /// Draws the weights.
  void initialise(Init init, Rng& rng);

  [[nodiscard]] const Shape& shape() const { return shape_; }
  [[nodiscard]] int n_layers() const { return static_cast<int>(shape_.hidden.size()) + 1; }
  /// Everything there is to learn, padding included (which is and stays 0).
  [[nodiscard]] Eigen::VectorXf& parameters() { return parameters_; }
  [[nodiscard]] const Eigen::VectorXf& parameters() const { return parameters_; }
  // [in x out] and [out] views of layer l: the kernels' order, y = x W + b.
  // ... (see mlp.cpp's owner)

 private:
  Shape shape_;
  Eigen::VectorXf parameters_;
};

}  // namespace modsearch
