#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace modsearch {

/// Adam (Kingma and Ba 2015, algorithm 1) with bias correction, after clipping the gradient's norm.
class Adam {
 public:
  struct Options {
    double beta1 = 0.9;     ///< of the mean of gradients. Kingma and Ba 2015, section 2
    double beta2 = 0.999;   ///< of the mean of squared gradients. Same place
    double epsilon = 1e-8;  ///< keeps the quotient finite. Same place
    double clip = 10.0;     ///< largest Euclidean norm of a gradient; longer ones are scaled back. Bester et al. 2019
  };
  /// Throws std::invalid_argument unless 0 <= beta1, beta2 < 1, epsilon > 0 and clip > 0.
  Adam(Eigen::Index size, Options options);

  /// weights -= rate * m^ / (sqrt(v^) + epsilon). Returns the norm of the gradient before clipping; `gradient` is not
  /// changed. Throws std::invalid_argument if the sizes differ.
  float step(Eigen::VectorXf& weights, const Eigen::VectorXf& gradient, float rate);

  // What a checkpoint keeps.
  Eigen::VectorXf m, v;    ///< means of the gradients and of their squares
  std::int64_t steps = 0;  ///< taken so far

 private:
  Options options_;
};

/// target += tau (source - target): Lillicrap et al. 2016. Throws std::invalid_argument if the sizes differ.
void soft_update(Eigen::VectorXf& target, const Eigen::VectorXf& source, float tau);

}  // namespace modsearch
