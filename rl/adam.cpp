#include <modsearch/rl/adam.hpp>

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace modsearch {

Adam::Adam(Eigen::Index size, Options options)
    : m{Eigen::VectorXf::Zero(size)}, v{Eigen::VectorXf::Zero(size)}, options_{options} {
  const auto refuse = [](const char* what, float value, const char* limit) {
    throw std::invalid_argument(fmt::format("Adam: {} = {}, must be {}", what, value, limit));
  };
  if (!(options.beta1 >= 0.0F && options.beta1 < 1.0F)) refuse("beta1", options.beta1, "in [0, 1)");
  if (!(options.beta2 >= 0.0F && options.beta2 < 1.0F)) refuse("beta2", options.beta2, "in [0, 1)");
  if (!(options.epsilon > 0.0F)) refuse("epsilon", options.epsilon, "above 0");
  if (!(options.clip > 0.0F)) refuse("clip", options.clip, "above 0");
}

float Adam::step(Eigen::VectorXf& weights, const Eigen::VectorXf& gradient, float rate) {
  if (weights.size() != m.size() || gradient.size() != m.size()) {
    throw std::invalid_argument(fmt::format("Adam: {} weights and {} slopes, made for {}", weights.size(),
                                            gradient.size(), m.size()));
  }
  const float norm = gradient.norm();
  const float scale = norm > options_.clip ? options_.clip / norm : 1.0F;
  ++steps;
  const double t = static_cast<double>(steps);
  const auto m_correction = static_cast<float>(1.0 / (1.0 - std::pow(static_cast<double>(options_.beta1), t)));
  const auto v_correction = static_cast<float>(1.0 / (1.0 - std::pow(static_cast<double>(options_.beta2), t)));
  m = options_.beta1 * m + (1.0F - options_.beta1) * scale * gradient;
  v.array() = options_.beta2 * v.array() + (1.0F - options_.beta2) * (scale * gradient.array()).square();
  weights.array() -= rate * m_correction * m.array() / ((v_correction * v.array()).sqrt() + options_.epsilon);
  return norm;
}

void soft_update(Eigen::VectorXf& target, const Eigen::VectorXf& source, float tau) {
  if (target.size() != source.size()) {
    throw std::invalid_argument(
        fmt::format("soft update: {} numbers from {}, sizes must be equal", target.size(), source.size()));
  }
  target += tau * (source - target);
}

}  // namespace modsearch
