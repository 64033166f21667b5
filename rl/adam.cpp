#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/rl/adam.hpp>
#include <modsearch/rl/float_kernels_internal.hpp>
#include <stdexcept>

namespace modsearch {

Adam::Adam(Eigen::Index size, Options options)
    : m{Eigen::VectorXf::Zero(size)}, v{Eigen::VectorXf::Zero(size)}, options_{options} {
  const auto refuse = [](const char* what, double value, const char* limit) {
    throw std::invalid_argument(fmt::format("Adam: {} = {}, must be {}", what, value, limit));
  };
  if (!(options.beta1 >= 0.0 && options.beta1 < 1.0)) refuse("beta1", options.beta1, "in [0, 1)");
  if (!(options.beta2 >= 0.0 && options.beta2 < 1.0)) refuse("beta2", options.beta2, "in [0, 1)");
  if (!(options.epsilon > 0.0)) refuse("epsilon", options.epsilon, "above 0");
  if (!(options.clip > 0.0)) refuse("clip", options.clip, "above 0");
}

float Adam::step(Eigen::VectorXf& weights, const Eigen::VectorXf& gradient, float rate) {
  if (weights.size() != m.size() || gradient.size() != m.size()) {
    throw std::invalid_argument(
        fmt::format("Adam: {} weights and {} slopes, made for {}", weights.size(), gradient.size(), m.size()));
  }
  const FloatKernels& kernels = float_kernels();
  const auto single = [](double value) { return static_cast<float>(value); };
  const float norm = std::sqrt(kernels.squared_norm(gradient.size(), gradient.data()));
  ++steps;
  const double t = static_cast<double>(steps);
  const double m_correction = 1.0 / (1.0 - std::pow(options_.beta1, t));
  const double v_correction = 1.0 / (1.0 - std::pow(options_.beta2, t));
  kernels.adam_step({.n = weights.size(),
                     .weights = weights.data(),
                     .gradient = gradient.data(),
                     .m = m.data(),
                     .v = v.data(),
                     .scale = single(std::min(1.0, options_.clip / static_cast<double>(norm))),
                     .beta1 = single(options_.beta1),
                     .rest1 = single(1.0 - options_.beta1),
                     .beta2 = single(options_.beta2),
                     .rest2 = single(1.0 - options_.beta2),
                     .rate = single(static_cast<double>(rate) * m_correction),
                     .v_correction = single(v_correction),
                     .epsilon = single(options_.epsilon)});
  return norm;
}

void soft_update(Eigen::VectorXf& target, const Eigen::VectorXf& source, float tau) {
  if (target.size() != source.size()) {
    throw std::invalid_argument(
        fmt::format("soft update: {} numbers from {}, sizes must be equal", target.size(), source.size()));
  }
  float_kernels().soft_update(target.size(), target.data(), source.data(), tau);
}

}  // namespace modsearch
