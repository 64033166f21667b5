#pragma once

#include <functional>
#include <memory>
#include <modsearch/rl/acting.hpp>
#include <modsearch/rl/agent.hpp>
#include <modsearch/rl/elite.hpp>
#include <modsearch/rl/exploration.hpp>
#include <modsearch/rl/replay.hpp>
#include <modsearch/rl/returns.hpp>
#include <optional>
#include <string_view>
#include <vector>

namespace modsearch {

/// The protocol of a training. Defaults are the report's: ten greedy episodes after every 30 training episodes, an end
/// after 300 evaluations without a new best, then 1000 greedy episodes.
struct TrainingOptions {
  std::int64_t episodes = 50'000;  ///< at most; the report
  std::int64_t replay = 300'000;   ///< experiences kept; the report
  int batch = 128;                 ///< per update; the report
  int warm_up = 128;               ///< experiences before the first update
  double updates_per_step = 1.0;   ///< Bester et al. 2019
  ReturnOptions returns{};
  ExplorationOptions exploration{};
  ActingOptions acting{};        ///< in training and evaluation alike
  int evaluate_every = 30;       ///< training episodes between evaluations; the report
  int evaluation_episodes = 10;  ///< greedy episodes per evaluation; the report
  int patience = 300;            ///< evaluations without a new best before training ends; 0: never. The report
  int final_episodes = 1000;     ///< greedy episodes at the end; the report
  double decay_from = 1.0;       ///< share of the episodes after which learning rates fall exponentially
  double decay_to = 1.0;         ///< their factor at the last episode
  double elite_share = 0.0;      ///< of each batch, drawn from the best successful episodes
  int elite_episodes = 64;       ///< kept for that; arbitrary
  int hindsight = 0;             ///< relabelled transitions per step (Andrychowicz et al. 2017)
  bool keep_best = false;        ///< the policy of the best evaluation is kept, not the last one
};

/// Greedy episodes in numbers.
struct EvaluationSummary {
  double mean_return = 0.0;     ///< sum of the rewards of an episode
  double deviation = 0.0;       ///< of the returns, corrected sample
  double success_share = 0.0;   ///< episodes that ended as they should
  double one_step_share = 0.0;  ///< episodes that did so in one step
  double mean_steps = 0.0;
};

/// One line of a training's history.
struct EvaluationPoint {
  std::int64_t episode = 0;  ///< training episodes so far
  std::int64_t steps = 0;    ///< environment steps
  std::int64_t updates = 0;
  double epsilon = 0.0;
  double training_return = 0.0;  ///< mean over the training episodes since the last point
  double value_loss = 0.0;       ///< mean over the updates since the last point
  double seconds = 0.0;          ///< of training, wall clock, evaluations left out
  EvaluationSummary evaluation;
};

enum class TrainingEnd {
  kEpisodes,     ///< all episodes are done
  kPatience,     ///< no new best for too long
  kInterrupted,  ///< somebody asked to stop
  kDiverged,     ///< a loss or a gradient is infinite or NaN: learning rates that are too large, mostly
};
/// "episodes", "patience", "interrupted", "diverged".
[[nodiscard]] std::string_view name(TrainingEnd end);

/// Training episodes until the first of `in_a_row` consecutive evaluations whose episodes all succeed in one step; the
/// report calls that stabilised.
[[nodiscard]] std::optional<std::int64_t> stabilised_after(const std::vector<EvaluationPoint>& history,
                                                           int in_a_row = 10);

/// Trains one agent in one environment. Everything random comes from streams numbered by episode and update, so a
/// training is a function of its seed, and one that is restored from a checkpoint goes on as if it had never stopped.
class Trainer {
 public:
  /// Called after every evaluation; false ends the training there.
  using Observer = std::function<bool(const Trainer&)>;

  /// `agent` must outlive it. Throws std::invalid_argument for options outside their ranges, or an agent that does not
  /// fit the environment.
  Trainer(Agent& agent, const Environment& environment, TrainingOptions options, Rng rng);

  /// Trains until the episodes are done, patience is over, the observer says stop, or `stop` returns true between
  /// episodes.
  TrainingEnd run(const Observer& observer = {}, const std::function<bool()>& stop = {});
  /// The agent gets the policy of the best evaluation so far where TrainingOptions::keep_best asks for it: for use,
  /// after the end. A training that goes on later needs the last one: save it before.
  void use_best_policy();
  /// Greedy episodes with the agent as it is: numbers `first` .. of a stream that training never uses.
  [[nodiscard]] EvaluationSummary evaluate(std::string_view stream, std::int64_t first, int episodes);

  [[nodiscard]] const std::vector<EvaluationPoint>& history() const { return history_; }
  [[nodiscard]] const TrainingOptions& options() const { return options_; }
  [[nodiscard]] std::int64_t episode() const { return episode_; }
  [[nodiscard]] std::int64_t steps() const { return steps_; }
  [[nodiscard]] std::int64_t updates() const { return updates_; }
  [[nodiscard]] double seconds() const { return seconds_; }
  [[nodiscard]] const Work& work() const { return work_; }  ///< of polish and model gradients, in this run
  [[nodiscard]] Agent& agent() { return agent_; }

  /// Everything that a later run needs, between two episodes.
  void save(Archive& archive) const;
  /// Throws FileError if the archive is of another kind of training.
  void load(const Archive& archive);

 private:
  void train_episode();
  void keep(std::vector<Experience> experiences);
  void learn(std::int64_t updates);
  void evaluate_now();

  Agent& agent_;
  std::unique_ptr<Environment> environment_;
  std::unique_ptr<Environment> evaluation_environment_;
  TrainingOptions options_;
  Rng rng_;
  Exploration exploration_;
  Returns returns_;
  Replay replay_;
  std::optional<Elite> elite_;
  std::vector<Experience> episode_experiences_;  // of the running episode, where there is an elite
  Batch batch_;

  std::int64_t episode_ = 0;
  std::int64_t steps_ = 0;
  std::int64_t updates_ = 0;
  double updates_owed_ = 0.0;
  double return_sum_ = 0.0;  // since the last evaluation
  double loss_sum_ = 0.0;
  std::int64_t updates_at_evaluation_ = 0;
  double seconds_ = 0.0;
  Work work_;
  double best_return_ = 0.0;
  std::int64_t best_evaluation_ = -1;  // index into history_
  std::vector<std::byte> best_policy_;
  std::vector<EvaluationPoint> history_;
  bool diverged_ = false;
};

}  // namespace modsearch
