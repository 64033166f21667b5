#include "environment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace modsearch::python {

Episodes::Episodes(ProblemSource source, DesignEnvironmentOptions options, int max_steps)
    : source_{source}, environment_{std::move(source), std::move(options)}, max_steps_{max_steps} {
  constexpr int kLeast = 2;
  if (max_steps_ < kLeast)
    throw std::invalid_argument(fmt::format("max_steps is {}, at least {} are needed", max_steps_, kLeast));
  environment_.set_evaluate(
      [this](const DesignProblem& problem, const Design& design, Fidelity fidelity) -> std::optional<Evaluation> {
        try {
          return problem.evaluate(design, fidelity);
        } catch (const EvaluationError& error) {
          failure_ = error.what();
          return std::nullopt;
        }
      });
  action_.x = Eigen::VectorXf::Zero(space().n_parameters());
}

void Episodes::seed(std::uint64_t seed) {
  rng_ = Rng{seed};
  episode_ = 0;
}

void Episodes::reset() { begin(episode_++); }

void Episodes::reset_to(const ProblemSource& source) {
  environment_.set_source(source);
  try {
    begin(episode_++);
  } catch (...) {
    environment_.set_source(source_);
    throw;
  }
  environment_.set_source(source_);
}

void Episodes::begin(std::uint64_t episode) {
  const OneAtATime::Inside inside{door_, "the environment"};
  environment_.reset(rng_.fork(episode));
  steps_ = 0;
  running_ = true;
}

Outcome Episodes::step(int k, std::span<const float> x_k) {
  const OneAtATime::Inside inside{door_, "the environment"};
  if (!running_) throw std::logic_error("a step outside an episode; reset comes first");
  if (k < 0 || k >= space().n_actions()) {
    throw std::invalid_argument(fmt::format("action {}: not in [0, {})", k, space().n_actions()));
  }
  Outcome outcome;
  outcome.masked = (environment_.mask() >> k & 1) == 0;
  if (!outcome.masked) {
    const auto n = static_cast<std::size_t>(space().count(k));
    if (x_k.size() < n)
      throw std::invalid_argument(fmt::format("action {}: {} parameters, {} are needed", k, x_k.size(), n));
    action_.k = k;
    std::copy_n(x_k.begin(), n, action_.x.data() + space().offset(k));
    failure_.clear();
    const Step step = environment_.step(action_);
    outcome.reward = step.reward;
    outcome.failed = step.unpaid;
    if (outcome.failed) outcome.failure = failure_.empty() ? "the score is not a number" : failure_;
    outcome.truncated = step.unpaid;  // what follows is not known
    // Where nothing may follow, that is how the task ends: no value is missed.
    outcome.terminated = step.terminated || (step.truncated && !step.unpaid);
  }
  if (const std::optional<Evaluation>& evaluation = environment_.evaluation(); evaluation && !outcome.failed) {
    outcome.score = evaluation->score;
    outcome.achieved = evaluation->attempt.achieved;
  }
  ++steps_;
  if (!outcome.terminated && steps_ >= max_steps_) outcome.truncated = true;
  running_ = !outcome.terminated && !outcome.truncated;
  return outcome;
}

void Episodes::observe(float* out) const {
  const Eigen::VectorXf& observation = environment_.observation();
  Eigen::Map<Eigen::VectorXf>(out, observation.size()) = observation.cwiseMax(-kBound).cwiseMin(kBound);
}

}  // namespace modsearch::python
