#include "table1/curve_lines.hpp"

#include <fmt/format.h>

#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/rl/design_environment.hpp>

namespace table1 {

using namespace modsearch;

namespace {

double random_return(DesignEnvironment& environment, Rng rng) {
  double sum = 0.0;
  while (environment.running()) {
    std::vector<int> allowed;
    for (int k = 0; k < environment.space().n_actions(); ++k) {
      if ((environment.mask() >> k) & 1U) allowed.push_back(k);
    }
    HybridAction action;
    action.k = allowed[static_cast<std::size_t>(rng.index(static_cast<int>(allowed.size())))];
    action.x.resize(environment.space().n_parameters());
    for (float& x : action.x) x = static_cast<float>(rng.uniform(-1.0, 1.0));
    sum += environment.step(action).reward;
  }
  return sum;
}

// What an episode earns that builds `design`.
double return_of(const DesignProblem& problem, const Design& design) {
  double sum = 0.0;
  for (int n = 1; n <= static_cast<int>(design.modules.size()); ++n) sum += problem.evaluate(design.prefix(n)).score;
  return sum;
}

}  // namespace

std::string curve_lines_csv(const CellRequest& request, const std::vector<EvaluationPoint>& history) {
  const LearnerSettings settings = settings_of(request);
  DesignEnvironment environment{source_of(request), settings.environment};
  // The streams from which the trainer draws the problems of its evaluations.
  const Rng evaluations = Rng{request.seed}.fork("training").fork("evaluation");
  const Rng random = Rng{request.seed}.fork("random actions");
  const int n = settings.training.evaluation_episodes;
  std::string csv = "episode,random_return,best_return\n";
  std::uint64_t number = 0;
  double best_of_fixed = 0.0;  // of a problem that is always the same
  const DesignProblem* fixed = nullptr;
  for (const EvaluationPoint& point : history) {
    double random_sum = 0.0;
    double best_sum = 0.0;
    for (int i = 0; i < n; ++i, ++number) {
      environment.reset(evaluations.fork(number));
      const DesignProblem& problem = environment.problem();
      if (fixed != &problem) {
        Meter meter;
        best_of_fixed = return_of(problem, PerSequence{}.solve(problem, meter, Rng{0}).design);
      }
      best_sum += best_of_fixed;
      random_sum += random_return(environment, random.fork(number));
      fixed = load_problem_file(request.problem).sampling ? nullptr : &problem;
    }
    csv += fmt::format("{},{:.4f},{:.4f}\n", point.episode, random_sum / n, best_sum / n);
  }
  return csv;
}

}  // namespace table1
