#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <modsearch/rl/learner.hpp>
#include <modsearch/rl/only_problem_internal.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

TrainingOptions consistent(const LearnerSettings& settings) {
  TrainingOptions options = settings.training;
  options.returns.remaining = settings.agent.mixed_target > 0.0;
  return options;
}

}  // namespace

AgentLearner::AgentLearner(LearnerSettings settings, Hooks hooks)
    : settings_{std::move(settings)}, hooks_{std::move(hooks)} {}

std::string AgentLearner::name() const { return std::string{modsearch::name(settings_.kind)}; }

Training AgentLearner::train(const ProblemSource& source, Meter& meter, Rng rng) const {
  DesignEnvironment environment{source, settings_.environment};
  environment.set_evaluate([&meter](const DesignProblem& problem, const Design& design, Fidelity fidelity) {
    return meter.evaluate(problem, design, fidelity);
  });
  const std::unique_ptr<Agent> agent = make_agent(settings_.kind, environment.space(), environment.observation_size(),
                                                  settings_.agent, rng.fork("agent"));
  Trainer trainer{*agent, environment, consistent(settings_), rng.fork("training")};
  if (hooks_.begin) hooks_.begin(trainer);
  Training training;
  training.end =
      trainer.run(hooks_.observer, [&] { return meter.stopped().has_value() || (hooks_.stop && hooks_.stop()); });
  if (hooks_.ended) hooks_.ended(trainer);
  trainer.use_best_policy();
  const bool done = training.end == TrainingEnd::kEpisodes || training.end == TrainingEnd::kPatience;
  if (done && settings_.training.final_episodes > 0) {
    training.final_evaluation = trainer.evaluate("final evaluation", 0, settings_.training.final_episodes);
  }
  meter.count(trainer.work());
  training.history = trainer.history();
  training.episodes = trainer.episode();
  training.steps = trainer.steps();
  training.updates = trainer.updates();
  training.seconds = trainer.seconds();
  LearnerSettings settings = settings_;
  settings.environment = environment.options();  // with the whitening it has found
  training.policy = std::make_unique<Policy>(std::move(settings), *agent);
  training.spent = meter.progress();
  return training;
}

Policy::Policy(LearnerSettings settings, Agent& agent)
    : settings_{std::move(settings)}, space_{agent.space()}, observation_size_{agent.observation_size()} {
  for (const StatePart& part : agent.state()) {
    if (!part.policy) continue;
    std::vector<float> values(part.bytes.size() / sizeof(float));
    std::memcpy(values.data(), part.bytes.data(), part.bytes.size());
    tensors_.emplace_back(part.name, std::move(values));
  }
  actor_ = this->agent();
}

Policy::Policy(LearnerSettings settings, HybridSpace space, int observation_size,
               std::vector<std::pair<std::string, std::vector<float>>> tensors)
    : settings_{std::move(settings)},
      space_{std::move(space)},
      observation_size_{observation_size},
      tensors_{std::move(tensors)},
      actor_{agent()} {}

std::unique_ptr<Agent> Policy::agent() const {
  std::unique_ptr<Agent> agent = make_agent(settings_.kind, space_, observation_size_, settings_.agent, Rng{0});
  for (const StatePart& part : agent->state()) {
    if (!part.policy) continue;
    const auto found =
        std::find_if(tensors_.begin(), tensors_.end(), [&](const auto& tensor) { return tensor.first == part.name; });
    if (found == tensors_.end()) throw std::invalid_argument(fmt::format("policy: no tensor '{}'", part.name));
    const std::size_t wanted = part.bytes.size() / sizeof(float);
    if (found->second.size() != wanted) {
      throw std::invalid_argument(
          fmt::format("policy: tensor '{}' has {} numbers, {} are needed", part.name, found->second.size(), wanted));
    }
    std::memcpy(part.bytes.data(), found->second.data(), part.bytes.size());
  }
  return agent;
}

SearchEnd Policy::do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const {
  DesignEnvironment environment{detail::only(problem), settings_.environment};
  if (!(environment.space() == space_) || environment.observation_size() != observation_size_) {
    throw std::invalid_argument(fmt::format(
        "policy: problem '{}' has {} types and observations of {} numbers, the policy was trained with {} and {}",
        problem.name(), environment.space().n_actions(), environment.observation_size(), space_.n_actions(),
        observation_size_));
  }
  environment.set_evaluate([&meter](const DesignProblem& p, const Design& design, Fidelity fidelity) {
    return meter.evaluate(p, design, fidelity);
  });
  const std::lock_guard lock{mutex_};
  environment.reset(rng.fork("episode"));
  Rng refine = rng.fork("refinement");
  Work work;
  int steps = 0;
  while (environment.running() && !meter.stopped()) {
    const HybridAction action = actor_->greedy(environment.observation(), environment.mask());
    static_cast<void>(environment.step(refined(action, environment, settings_.training.acting, refine, work)));
    ++steps;
  }
  meter.count(work);
  return {.stop = StopReason::kExhausted,
          .reason = fmt::format("{} placed {} module{}", actor_->name(), steps, steps == 1 ? "" : "s"),
          .bound = std::nullopt};
}

}  // namespace modsearch
