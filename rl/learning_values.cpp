#include <fmt/format.h>

#include <modsearch/rl/learning_values.hpp>

namespace modsearch {

LearningValues::LearningValues(ValueKind kind, const HybridSpace& space, int observation_size,
                               const AgentOptions& options, Rng rng)
    : tau_{static_cast<float>(options.value_tau)} {
  const ActionValues::Options values{.observation_size = observation_size,
                                     .hidden = options.value_hidden,
                                     .leak = static_cast<float>(options.leak),
                                     .output_deviation = static_cast<float>(options.value_output_deviation)};
  for (std::uint64_t i = 0; i < (options.td3.twin ? 2U : 1U); ++i) {
    std::unique_ptr<ActionValues> q = make_action_values(kind, space, values, rng.fork("values").fork(i));
    std::unique_ptr<ActionValues> q_target = q->clone();
    const Eigen::Index n = q->parameters().size();
    critics_.push_back({std::move(q), std::move(q_target), Adam{n, options.adam()}, Eigen::VectorXf::Zero(n)});
  }
}

RowMatrixXf LearningValues::target(const RowMatrixXf& s, const RowMatrixXf& x) {
  RowMatrixXf q = critics_.front().q_target->forward(s, x);
  for (std::size_t i = 1; i < critics_.size(); ++i) q = q.cwiseMin(critics_[i].q_target->forward(s, x));
  return q;
}

void LearningValues::fit(const RowMatrixXf& s, const RowMatrixXf& x, const Eigen::VectorXi& k,
                         const Eigen::VectorXf& y, double rate, UpdateFacts& facts) {
  const auto n = static_cast<float>(y.size());
  for (Critic& critic : critics_) {
    const Eigen::VectorXf difference = critic.q->forward_taken(s, x, k) - y;
    facts.value_loss += difference.squaredNorm() / n;
    critic.gradient.setZero();
    critic.q->weights_gradient(2.0F / n * difference, critic.gradient);
    facts.value_gradient += critic.adam.step(critic.q->parameters(), critic.gradient, static_cast<float>(rate));
  }
}

void LearningValues::follow() {
  for (Critic& critic : critics_) soft_update(critic.q_target->parameters(), critic.q->parameters(), tau_);
}

void LearningValues::append_state(std::vector<StatePart>& parts, bool acts) {
  for (std::size_t i = 0; i < critics_.size(); ++i) {
    Critic& critic = critics_[i];
    const std::string q = fmt::format("q{}", i);
    parts.push_back(state_part(q, critic.q->parameters(), acts && i == 0));
    parts.push_back(state_part(q + ".target", critic.q_target->parameters()));
    parts.push_back(state_part(q + ".adam.m", critic.adam.m));
    parts.push_back(state_part(q + ".adam.v", critic.adam.v));
    parts.push_back(state_part(q + ".adam.steps", critic.adam.steps));
  }
}

}  // namespace modsearch
