// Step 6: train an agent on a family of problems, then use it as a solver beside the classical ones.
#include <iostream>
#include <modsearch/modsearch.hpp>

int main() {
  using namespace modsearch;

  // 1. A family: every episode of the training draws a target of its own.
  const ProblemFile family = load_problem_file("seed/random_narrow");

  // 2. MP-DQN with our best settings for sampled targets; any of them can be changed.
  LearnerSettings settings = settings_of(AgentKind::kMpdqn, Preset::kBest, traits_of(family));
  settings.training.episodes = 1500;
  Meter training_meter{{.evaluations = 100'000}};
  const Training training = AgentLearner{settings}.train(problem_source(family), training_meter, Rng{0});
  std::cout << "trained for " << training.history.back().episode << " episodes, " << training.spent.evaluations
            << " evaluations\n";

  // 3. Its policy is a solver like any other. Training and use are metered apart.
  const PerSequence optimiser{{.starts = 8}};
  int one_module = 0;
  double regret = 0.0;
  constexpr int kInstances = 50;
  for (std::uint64_t i = 0; i < kInstances; ++i) {
    const auto problem = family.instance({.seed = 1, .index = i});
    Meter meter, other_meter;
    const Solution learned = training.policy->solve(*problem, meter, Rng{i});
    const Solution best = optimiser.solve(*problem, other_meter, Rng{i});
    one_module += learned.evaluation.attempt.achieved && learned.design.modules.size() == 1;
    regret += (best.evaluation.score - learned.evaluation.score) / kInstances;
  }
  std::cout << one_module << " of " << kInstances << " held-out targets with one module, mean regret " << regret << '\n';

  // 4. The control that belongs beside such a number: the same polish on random parameters needs no training at all
  //    (docs/agents.md).
}
