#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <modsearch/rl/training.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

void require(bool holds, const char* what, double value, const char* limit) {
  if (!holds) throw std::invalid_argument(fmt::format("training: {} = {}, not in {}", what, value, limit));
}

void check(const TrainingOptions& options) {
  require(options.episodes >= 1, "episodes", static_cast<double>(options.episodes), "[1, ..)");
  require(options.batch >= 1, "batch", options.batch, "[1, ..)");
  require(options.warm_up >= 1, "warm-up", options.warm_up, "[1, ..)");
  require(options.updates_per_step >= 0.0 && std::isfinite(options.updates_per_step), "updates per step",
          options.updates_per_step, "[0, inf)");
  require(options.warm_up <= options.replay, "warm-up", options.warm_up, "[1, capacity of the replay]");
  require(options.evaluate_every >= 1, "episodes between evaluations", options.evaluate_every, "[1, ..)");
  require(options.evaluation_episodes >= 1, "episodes per evaluation", options.evaluation_episodes, "[1, ..)");
  require(options.patience >= 0, "patience", options.patience, "[0, ..)");
  require(options.decay_from >= 0.0 && options.decay_from <= 1.0, "start of the decay", options.decay_from, "[0, 1]");
  require(options.decay_to > 0.0 && options.decay_to <= 1.0, "end of the decay", options.decay_to, "(0, 1]");
  require(options.elite_share >= 0.0 && options.elite_share <= 1.0, "share of the elite", options.elite_share,
          "[0, 1]");
  require(options.final_episodes >= 0, "final episodes", options.final_episodes, "[0, ..)");
  require(options.acting.polish >= 0, "steps of the polish", options.acting.polish, "[0, ..)");
  require(options.acting.proposals >= 1, "proposals", options.acting.proposals, "[1, ..)");
  require(options.acting.proposal_deviation >= 0.0, "deviation of the proposals", options.acting.proposal_deviation,
          "[0, inf)");
  require(options.hindsight >= 0, "hindsight transitions per step", options.hindsight, "[0, ..)");
}

std::vector<std::byte> policy_bytes(Agent& agent) {
  std::vector<std::byte> bytes;
  for (const StatePart& part : agent.state()) {
    if (part.policy) bytes.insert(bytes.end(), part.bytes.begin(), part.bytes.end());
  }
  return bytes;
}

}  // namespace

std::string_view name(TrainingEnd end) {
  switch (end) {
    case TrainingEnd::kEpisodes:
      return "episodes";
    case TrainingEnd::kPatience:
      return "patience";
    case TrainingEnd::kInterrupted:
      return "interrupted";
    case TrainingEnd::kDiverged:
      return "diverged";
  }
  return "";
}

std::optional<std::int64_t> stabilised_after(const std::vector<EvaluationPoint>& history, int in_a_row) {
  int run = 0;
  for (std::size_t i = 0; i < history.size(); ++i) {
    run = history[i].evaluation.one_step_share >= 1.0 ? run + 1 : 0;
    if (run == in_a_row) return history[i + 1 - static_cast<std::size_t>(in_a_row)].episode;
  }
  return std::nullopt;
}

Trainer::Trainer(Agent& agent, const Environment& environment, TrainingOptions options, Rng rng)
    : agent_{agent},
      environment_{environment.clone()},
      evaluation_environment_{environment.clone()},
      options_{options},
      rng_{rng},
      exploration_{options.exploration, agent.space().n_parameters()},
      returns_{options.returns, agent.gamma()},
      replay_{options.replay, agent.observation_size(), agent.memory_size()} {
  check(options_);
  if (!(agent.space() == environment.space()) || agent.observation_size() != environment.observation_size()) {
    throw std::invalid_argument(
        fmt::format("training: agent {} does not fit environment {}", agent.name(), environment.name()));
  }
  if (options_.elite_share > 0.0) elite_.emplace(options_.elite_episodes);
}

TrainingEnd Trainer::run(const Observer& observer, const std::function<bool()>& stop) {
  while (episode_ < options_.episodes) {
    if (stop && stop()) return TrainingEnd::kInterrupted;
    const auto start = std::chrono::steady_clock::now();
    train_episode();
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (diverged_) return TrainingEnd::kDiverged;
    if (episode_ % options_.evaluate_every != 0) continue;
    evaluate_now();
    if (observer && !observer(*this)) return TrainingEnd::kInterrupted;
    const auto last = static_cast<std::int64_t>(history_.size()) - 1;
    if (options_.patience > 0 && last - best_evaluation_ >= options_.patience) return TrainingEnd::kPatience;
  }
  return TrainingEnd::kEpisodes;
}

void Trainer::train_episode() {
  const auto number = static_cast<std::uint64_t>(episode_);
  environment_->reset(rng_.fork("episode").fork(number));
  Rng explore = rng_.fork("exploration").fork(number);
  Rng refine = rng_.fork("refinement").fork(number);
  Rng relabel = rng_.fork("hindsight").fork(number);
  exploration_.begin_episode(explore);
  returns_ = Returns{options_.returns, agent_.gamma()};  // nothing is left of an episode that an exception ended
  episode_experiences_.clear();
  double episode_return = 0.0;
  bool success = false;
  while (environment_->running() && !diverged_) {
    Transition t;
    t.s = environment_->observation();
    t.model = environment_->model();
    t.action = exploration_.act(agent_, t.s, environment_->mask(), episode_, explore);
    const Step step = environment_->step(refined(t.action, *environment_, options_.acting, refine, work_));
    if (step.unpaid) break;
    episode_return += step.reward;
    success = step.success;
    ++steps_;

    for (Transition& other : environment_->hindsight(options_.hindsight, relabel)) {
      other.action = t.action;
      keep(Returns{options_.returns, agent_.gamma()}.add(agent_, std::move(other)));
    }
    t.reward = static_cast<float>(step.reward);
    t.s_next = environment_->observation();
    t.next_mask = environment_->mask();
    t.terminated = step.terminated;
    t.truncated = step.truncated;
    std::vector<Experience> ready = returns_.add(agent_, std::move(t));
    if (elite_) episode_experiences_.insert(episode_experiences_.end(), ready.begin(), ready.end());
    keep(std::move(ready));
    updates_owed_ += options_.updates_per_step;
    learn(static_cast<std::int64_t>(updates_owed_));
    updates_owed_ -= std::floor(updates_owed_);
  }
  if (elite_ && success) elite_->add(episode_return, episode_experiences_);
  episode_experiences_.clear();
  return_sum_ += episode_return;
  ++episode_;
}

void Trainer::keep(std::vector<Experience> experiences) {
  for (const Experience& experience : experiences) replay_.add(experience);
}

void Trainer::learn(std::int64_t updates) {
  if (replay_.size() < options_.warm_up) return;
  const double share = static_cast<double>(episode_) / static_cast<double>(options_.episodes);
  if (options_.decay_to < 1.0 && share > options_.decay_from) {
    agent_.set_rate_factor(std::pow(options_.decay_to, (share - options_.decay_from) / (1.0 - options_.decay_from)));
  }
  const int elite =
      elite_ && !elite_->empty() ? static_cast<int>(std::lround(options_.elite_share * options_.batch)) : 0;
  for (; updates > 0 && !diverged_; --updates) {
    Rng draw = rng_.fork("update").fork(static_cast<std::uint64_t>(updates_++));
    batch_.resize(options_.batch, agent_.observation_size(), agent_.memory_size());
    replay_.sample(draw, 0, options_.batch - elite, batch_);
    if (elite > 0) elite_->sample(draw, options_.batch - elite, elite, batch_);
    const UpdateFacts facts = agent_.update(batch_, draw);
    diverged_ = !std::isfinite(facts.value_loss) || !std::isfinite(facts.value_gradient) ||
                !std::isfinite(facts.actor_gradient);
    loss_sum_ += facts.value_loss;
    work_ += facts.work;
  }
}

void Trainer::evaluate_now() {
  EvaluationPoint point;
  point.episode = episode_;
  point.steps = steps_;
  point.updates = updates_;
  point.epsilon = exploration_.epsilon(episode_);
  point.training_return = return_sum_ / options_.evaluate_every;
  point.value_loss =
      updates_ > updates_at_evaluation_ ? loss_sum_ / static_cast<double>(updates_ - updates_at_evaluation_) : 0.0;
  point.seconds = seconds_;
  const auto first = static_cast<std::int64_t>(history_.size()) * options_.evaluation_episodes;
  point.evaluation = evaluate("evaluation", first, options_.evaluation_episodes);
  return_sum_ = loss_sum_ = 0.0;
  updates_at_evaluation_ = updates_;
  if (best_evaluation_ < 0 || point.evaluation.mean_return > best_return_) {
    best_return_ = point.evaluation.mean_return;
    best_evaluation_ = static_cast<std::int64_t>(history_.size());
    if (options_.keep_best) best_policy_ = policy_bytes(agent_);
  }
  history_.push_back(point);
}

EvaluationSummary Trainer::evaluate(std::string_view stream, std::int64_t first, int episodes) {
  EvaluationSummary summary;
  if (episodes < 1) return summary;
  Environment& environment = *evaluation_environment_;
  double squares = 0.0;
  for (int i = 0; i < episodes; ++i) {
    const auto number = static_cast<std::uint64_t>(first + i);
    environment.reset(rng_.fork(stream).fork(number));
    Rng refine = rng_.fork("refinement of an evaluation").fork(number);
    double episode_return = 0.0;
    int steps = 0;
    Step step;
    while (environment.running()) {
      const HybridAction action = agent_.greedy(environment.observation(), environment.mask());
      step = environment.step(refined(action, environment, options_.acting, refine, work_));
      episode_return += step.reward;
      ++steps;
    }
    // Welford's update of mean and sum of squares.
    const double difference = episode_return - summary.mean_return;
    summary.mean_return += difference / (i + 1);
    squares += difference * (episode_return - summary.mean_return);
    summary.success_share += step.success;
    summary.one_step_share += step.success && steps == 1;
    summary.mean_steps += steps;
  }
  summary.deviation = episodes > 1 ? std::sqrt(squares / (episodes - 1)) : 0.0;
  summary.success_share /= episodes;
  summary.one_step_share /= episodes;
  summary.mean_steps /= episodes;
  return summary;
}

void Trainer::use_best_policy() {
  if (!options_.keep_best || best_policy_.empty()) return;
  auto from = best_policy_.cbegin();
  for (const StatePart& part : agent_.state()) {
    if (!part.policy) continue;
    const auto n = static_cast<std::ptrdiff_t>(part.bytes.size());
    std::copy(from, from + n, part.bytes.begin());
    from += n;
  }
}

}  // namespace modsearch
