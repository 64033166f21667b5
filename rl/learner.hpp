#pragma once

#include <filesystem>
#include <memory>
#include <modsearch/problem/problem_source.hpp>
#include <modsearch/rl/settings.hpp>
#include <modsearch/rl/training.hpp>
#include <modsearch/solvers/solver.hpp>
#include <mutex>
#include <string>
#include <vector>

namespace modsearch {

/// What a training gives.
struct Training {
  std::unique_ptr<Solver> policy;  ///< the trained agent, as a solver
  std::vector<EvaluationPoint> history;
  EvaluationSummary final_evaluation;  ///< greedy episodes after the end
  TrainingEnd end = TrainingEnd::kEpisodes;
  std::int64_t episodes = 0;  ///< of training, those before a checkpoint included; the same for steps, updates, seconds
  std::int64_t steps = 0;
  std::int64_t updates = 0;
  double seconds = 0.0;  ///< wall clock, evaluations left out
  Progress spent;  ///< evaluations of training and its evaluations, inner work included; use is metered apart
};

/// Learns from a family of problems and gives a solver for them.
class Learner {
 public:
  virtual ~Learner() = default;
  [[nodiscard]] virtual std::string name() const = 0;
  /// Trains until the learner's own protocol or the meter says stop. Equal arguments give equal policies (unless a
  /// budget of seconds cuts in). Throws what the problems throw.
  [[nodiscard]] virtual Training train(const ProblemSource& source, Meter& meter, Rng rng) const = 0;
};

/// Training of an agent in the environment of a problem family.
class AgentLearner final : public Learner {
 public:
  /// Where training goes on from and what it tells on the way; all may be empty.
  struct Hooks {
    std::function<void(Trainer&)> begin;        ///< before the first episode: to load a checkpoint
    Trainer::Observer observer;                 ///< after every evaluation; false ends the training
    std::function<bool()> stop;                 ///< whether to end, asked between two episodes
    std::function<void(const Trainer&)> ended;  ///< after the last episode: to keep a checkpoint
  };
  explicit AgentLearner(LearnerSettings settings, Hooks hooks = {});

  [[nodiscard]] std::string name() const override;
  [[nodiscard]] Training train(const ProblemSource& source, Meter& meter, Rng rng) const override;

 private:
  LearnerSettings settings_;
  Hooks hooks_;
};

/// A trained agent's greedy behaviour: one module after the other, refined as in training, each prefix evaluated. It
/// knows the family of problems it was trained on, and nothing else.
class Policy final : public Solver {
 public:
  /// A copy of `agent`'s memory for acting.
  Policy(LearnerSettings settings, Agent& agent);
  /// From tensors by name, as tensors() gave them. Throws std::invalid_argument if they do not fit the settings.
  Policy(LearnerSettings settings, HybridSpace space, int observation_size,
         std::vector<std::pair<std::string, std::vector<float>>> tensors);

  [[nodiscard]] std::string name() const override { return "policy"; }
  [[nodiscard]] const LearnerSettings& settings() const { return settings_; }
  [[nodiscard]] const HybridSpace& space() const { return space_; }
  [[nodiscard]] int observation_size() const { return observation_size_; }
  [[nodiscard]] const std::vector<std::pair<std::string, std::vector<float>>>& tensors() const { return tensors_; }
  /// The agent itself, with its weights.
  [[nodiscard]] std::unique_ptr<Agent> agent() const;
  /// How its proposals are refined; the settings of the training unless changed.
  void set_acting(ActingOptions acting) { settings_.training.acting = acting; }

 private:
  [[nodiscard]] SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const override;

  LearnerSettings settings_;
  HybridSpace space_;
  int observation_size_;
  std::vector<std::pair<std::string, std::vector<float>>> tensors_;
  mutable std::mutex mutex_;  // an agent computes in its own memory: one solve at a time
  mutable std::unique_ptr<Agent> actor_;
};

}  // namespace modsearch
