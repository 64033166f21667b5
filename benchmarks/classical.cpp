// What the classical solvers find at equal evaluations: medians over instances and seeds, no timing
// (docs/baselines.md).
//
//   classical [--problems A B ..] [--solvers A B ..] [--evaluations N] [--instances N] [--seeds N] [--draw SEED]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/problem/files.hpp>

#include "app/solver_registry.hpp"

namespace modsearch {
namespace {

// The seed library with other bounds of all lengths [m].
std::shared_ptr<const ModuleLibrary> with_lengths(const ModuleLibrary& library, double lower, double upper) {
  std::vector<ModuleType> modules{library.base()};
  for (int k = 0; k < library.n_types(); ++k) {
    modules.push_back(library.type(k));
    for (ParameterRange& range : modules.back().parameters) {
      range.lower = lower;
      range.upper = upper;
    }
  }
  return std::make_shared<const ModuleLibrary>("short", std::move(modules), library.neighbour_rule());
}

// "ID", "short:ID": lengths in [0.2, 0.6] m, so that two to four modules are needed; "two:ID": the targets of two
// instances, one after the other.
std::shared_ptr<const RobotProblem> instance(const std::string& name, std::uint64_t seed, std::uint64_t index) {
  const auto plain = [&](std::size_t prefix, std::uint64_t i) { return load_problem(name.substr(prefix), {seed, i}); };
  if (name.starts_with("short:")) {
    RobotProblemSpec spec = plain(6, index)->spec();
    spec.library = with_lengths(*spec.library, 0.2, 0.6);
    spec.name = name;
    return std::make_shared<RobotProblem>(std::move(spec));
  }
  if (name.starts_with("two:")) {
    RobotProblemSpec spec = plain(4, 2 * index)->spec();
    std::vector<Goal> goals{spec.task->goals()[0], plain(4, 2 * index + 1)->task().goals()[0]};
    goals[1].id = "2";
    spec.task = std::make_shared<GoalTask>(name, std::move(goals));
    spec.name = name;
    return std::make_shared<RobotProblem>(std::move(spec));
  }
  return plain(0, index);
}

struct Run {
  std::size_t instance = 0;
  bool achieved = false;
  double score = 0.0;
  std::size_t modules = 0;
  Progress spent;
};

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(q * static_cast<double>(values.size() - 1)))];
}

struct Arguments {
  std::vector<std::string> problems{"seed/fixed",
                                    "seed/random_wide",
                                    "seed/random_obstacles",
                                    "short:seed/random_wide",
                                    "short:seed/random_obstacles",
                                    "two:seed/random_wide"};
  std::vector<std::string> solvers{"random", "per-sequence", "ga", "ga:polish=0", "cmaes", "anneal"};
  std::int64_t evaluations = 2000;
  std::size_t instances = 15;
  std::uint64_t seeds = 10;
  std::uint64_t draw = 2024;
};

void table(const Arguments& arguments, const std::string& problem) {
  std::map<std::string, std::vector<Run>> runs;
  std::vector<double> best(arguments.instances, -std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < arguments.instances; ++i) {
    const auto drawn = instance(problem, arguments.draw, i);
    const auto offer = [&](const Solution& solution) {
      if (solution.evaluation.attempt.achieved) best[i] = std::max(best[i], solution.evaluation.score);
    };
    // The best known does not depend on who takes part.
    Meter meter;
    offer(PerSequence{{.starts = 32}}.solve(*drawn, meter, Rng{0}));
    for (const std::string& text : arguments.solvers) {
      const app::ChosenSolver chosen = app::choose_solver(text);
      for (std::uint64_t seed = 0; seed < arguments.seeds; ++seed) {
        Meter budget{{.evaluations = arguments.evaluations}};
        const Solution solution = chosen.solver->solve(*drawn, budget, Rng{seed});
        offer(solution);
        const Evaluation& evaluation = solution.evaluation;
        runs[text].push_back(
            {i, evaluation.attempt.achieved, evaluation.score, solution.design.modules.size(), solution.spent});
      }
    }
  }
  fmt::print(
      "\n`{}`\n\n| solver | achieved | within 1 point | regret: median | 90 % | evaluations | of programs | s |\n"
      "|---|---|---|---|---|---|---|---|\n",
      problem);
  for (const std::string& solver : arguments.solvers) {
    std::vector<double> regrets, evaluations, programs, seconds;
    int achieved = 0, close = 0;
    for (const Run& run : runs[solver]) {
      // Regret is among achieved designs; one that is not achieved ranks below them all.
      const double regret = run.achieved ? best[run.instance] - run.score : std::numeric_limits<double>::infinity();
      regrets.push_back(regret);
      achieved += run.achieved ? 1 : 0;
      close += regret < 1.0 ? 1 : 0;
      evaluations.push_back(static_cast<double>(run.spent.evaluations));
      programs.push_back(static_cast<double>(run.spent.program_evaluations));
      seconds.push_back(run.spent.seconds);
    }
    const auto share = [&](int n) { return 100.0 * n / static_cast<double>(regrets.size()); };
    fmt::print("| `{}` | {:.0f} % | {:.0f} % | {:.3f} | {:.3f} | {:.0f} | {:.0f} | {:.2f} |\n", solver, share(achieved),
               share(close), quantile(regrets, 0.5), quantile(regrets, 0.9), quantile(evaluations, 0.5),
               quantile(programs, 0.5), quantile(seconds, 0.5));
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace modsearch

int main(int argc, char** argv) {
  modsearch::Arguments arguments;
  CLI::App program{"Classical solvers at equal evaluations"};
  program.add_option("--problems", arguments.problems, "IDs, with short: or two: before them");
  program.add_option("--solvers", arguments.solvers, "as for `modsearch solve`");
  program.add_option("--evaluations", arguments.evaluations, "budget of a run");
  program.add_option("--instances", arguments.instances, "per problem");
  program.add_option("--seeds", arguments.seeds, "per instance");
  program.add_option("--draw", arguments.draw, "seed of the instances");
  CLI11_PARSE(program, argc, argv);
  for (const std::string& problem : arguments.problems) modsearch::table(arguments, problem);
}
