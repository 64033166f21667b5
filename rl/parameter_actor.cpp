#include <fmt/format.h>

#include <modsearch/rl/actor_gradient.hpp>
#include <modsearch/rl/parameter_actor.hpp>
#include <stdexcept>

namespace modsearch {

ParameterActor::ParameterActor(const HybridSpace& space, int observation_size, int n_heads, const AgentOptions& options,
                               Rng rng)
    : network_{{.inputs = observation_size,
                .hidden = options.actor_hidden,
                .outputs = n_heads + space.n_parameters(),
                .leak = static_cast<float>(options.leak)}},
      n_heads_{n_heads} {
  Rng weights = rng.fork("actor");
  network_.initialise({.output_deviation = static_cast<float>(options.actor_output_deviation)}, weights);

  const Eigen::Index n = space.n_parameters();
  const Eigen::Index n_weights = n * observation_size;
  Rng draw = rng.fork("passthrough");
  passthrough_.setZero(n_weights + n);
  for (float& w : passthrough_.head(n_weights)) {
    w = static_cast<float>(options.passthrough_weight_mean + options.passthrough_weight_deviation * draw.normal());
  }
  auto bias = passthrough_.tail(n);
  if (!options.passthrough_bias.empty()) {
    if (static_cast<Eigen::Index>(options.passthrough_bias.size()) != n) {
      throw std::invalid_argument(fmt::format("passthrough bias: {} numbers, {} are needed, one per parameter",
                                              options.passthrough_bias.size(), n));
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      bias[i] = static_cast<float>(options.passthrough_bias[static_cast<std::size_t>(i)]);
    }
  } else {
    for (float& b : bias) b = static_cast<float>(options.passthrough_bias_deviation * draw.normal());
  }
  has_passthrough_ = options.passthrough_rate > 0.0 || !passthrough_.isZero(0.0F);
}

const RowMatrixXf& ParameterActor::forward(const RowMatrixXf& s) {
  outputs_ = network_.forward(s, pass_);
  if (!has_passthrough_) return outputs_;
  const Eigen::Index n = outputs_.cols() - n_heads_;
  const Eigen::Map<const Eigen::MatrixXf> w{passthrough_.data(), n, s.cols()};
  outputs_.rightCols(n).noalias() += s * w.transpose();
  outputs_.rightCols(n).rowwise() += passthrough_.tail(n).transpose();
  return outputs_;
}

Eigen::VectorXf ParameterActor::forward_one(const Eigen::VectorXf& s) {
  Eigen::VectorXf outputs = network_.forward_one(s, pass_);
  if (!has_passthrough_) return outputs;
  const Eigen::Index n = outputs.size() - n_heads_;
  const Eigen::Map<const Eigen::MatrixXf> w{passthrough_.data(), n, s.size()};
  outputs.tail(n).noalias() += w * s;
  outputs.tail(n) += passthrough_.tail(n);
  return outputs;
}

void ParameterActor::backward(const RowMatrixXf& d_outputs, Eigen::VectorXf& gradient) {
  network_.backward(d_outputs, pass_, &gradient, nullptr);
}

void ParameterActor::passthrough_backward(const RowMatrixXf& d_outputs, const RowMatrixXf& s,
                                          Eigen::VectorXf& gradient) const {
  const Eigen::Index n = d_outputs.cols() - n_heads_;
  Eigen::Map<Eigen::MatrixXf> w{gradient.data(), n, s.cols()};
  w.noalias() += d_outputs.rightCols(n).transpose() * s;
  gradient.tail(n) += d_outputs.rightCols(n).colwise().sum().transpose();
}

LearningActor::LearningActor(const HybridSpace& space, int observation_size, int n_heads, const AgentOptions& options,
                             Rng rng)
    : mu{space, observation_size, n_heads, options, rng},
      target{mu},
      bounds_{options.bounds},
      bound_{static_cast<float>(options.bound)},
      average_{options.average},
      tau_{static_cast<float>(options.actor_tau)},
      rate_{options.actor_rate},
      passthrough_rate_{options.passthrough_rate},
      adam_{mu.parameters().size(), options.adam()},
      passthrough_adam_{passthrough_rate_ > 0.0 ? mu.passthrough().size() : 0, options.adam()},
      gradient_{Eigen::VectorXf::Zero(mu.parameters().size())},
      passthrough_gradient_{Eigen::VectorXf::Zero(passthrough_adam_.m.size())} {}

double LearningActor::climb(RowMatrixXf g, const RowMatrixXf& s, const RowMatrixXf& outputs, double rate_factor) {
  switch (bounds_) {
    case BoundGradients::kInvert:
      invert_gradients(g, outputs, bound_);
      break;
    case BoundGradients::kZero:
      zero_outward_gradients(g, outputs, bound_);
      break;
    case BoundGradients::kNone:
      break;
  }
  g = -g;
  if (passthrough_rate_ > 0.0) {
    passthrough_gradient_.setZero();
    mu.passthrough_backward(g, s, passthrough_gradient_);
    passthrough_adam_.step(mu.passthrough(), passthrough_gradient_,
                           static_cast<float>(passthrough_rate_ * rate_factor));
  }
  gradient_.setZero();
  mu.backward(g, gradient_);
  return adam_.step(mu.parameters(), gradient_, static_cast<float>(rate_ * rate_factor));
}

void LearningActor::follow() {
  soft_update(target.parameters(), mu.parameters(), tau_);
  if (passthrough_rate_ > 0.0) soft_update(target.passthrough(), mu.passthrough(), tau_);
}

void LearningActor::append_state(std::vector<StatePart>& parts) {
  parts.push_back(state_part("mu", mu.parameters(), !average_));
  parts.push_back(state_part("mu.passthrough", mu.passthrough(), !average_));
  parts.push_back(state_part("mu.target", target.parameters(), average_));
  parts.push_back(state_part("mu.target.passthrough", target.passthrough(), average_));
  parts.push_back(state_part("mu.adam.m", adam_.m));
  parts.push_back(state_part("mu.adam.v", adam_.v));
  parts.push_back(state_part("mu.adam.steps", adam_.steps));
  if (passthrough_rate_ == 0.0) return;
  parts.push_back(state_part("mu.passthrough.adam.m", passthrough_adam_.m));
  parts.push_back(state_part("mu.passthrough.adam.v", passthrough_adam_.v));
  parts.push_back(state_part("mu.passthrough.adam.steps", passthrough_adam_.steps));
}

}  // namespace modsearch
