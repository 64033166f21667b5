#pragma once

#include <Eigen/Core>

namespace modsearch {

/// Adam (Kingma and Ba 2015, algorithm 1) with bias correction, after clipping the gradient's norm.
class Adam {
 public:
  struct Options {
    float beta1 = 0.9F;
    float beta2 = 0.999F;
    float epsilon = 1e-8F;
    float clip = 10.0F;  ///< largest Euclidean norm of a gradient; longer ones are scaled back. Bester et al. 2019
  };
  Adam(Eigen::Index size, Options options);

  /// weights -= rate * m^ / (sqrt(v^) + epsilon). Returns the norm of the gradient before clipping.
  /// Throws std::invalid_argument if the sizes differ.
  float step(Eigen::VectorXf& weights, Eigen::VectorXf& gradient, float rate);

  // What a checkpoint keeps.
  Eigen::VectorXf m, v;
  std::int64_t steps = 0;

 private:
  Options options_;
};

/// target += tau (source - target): Lillicrap et al. 2016.
void soft_update(Eigen::VectorXf& target, const Eigen::VectorXf& source, float tau);

}  // namespace modsearch
