#include "study/synthetic_study.hpp"

#include <fmt/format.h>

#include <cmath>
#include <modsearch/problem/rng.hpp>

namespace modsearch::testing {
namespace {

constexpr double kSecondsPerEvaluation = 2e-4;

// Algorithm 1 for a free two-module arm (the base counts): 350 - 5 m.
double score_of(double mass) { return 350.0 - 5.0 * mass; }

double least_mass(std::uint64_t instance) { return 1.6 + 0.02 * static_cast<double>(instance); }

Improvement achieved_with(std::int64_t evaluations, double mass) {
  return {.evaluations = evaluations,
          .seconds = kSecondsPerEvaluation * static_cast<double>(evaluations),
          .score = score_of(mass),
          .achieved = true,
          .modules = 2,
          .mass = mass};
}

// Excess mass after e evaluations: `scale` / e, found whenever e doubles.
std::vector<Improvement> halving(double least, double scale, std::int64_t budget) {
  std::vector<Improvement> out{{.evaluations = 1, .seconds = kSecondsPerEvaluation, .score = -12.0, .mass = 2.2}};
  for (std::int64_t e = 4; e <= budget; e *= 2) {
    out.push_back(achieved_with(e, least * (1.0 + scale / static_cast<double>(e))));
  }
  return out;
}

void finish(CellRecord& cell, std::vector<Improvement> trace) {
  const Improvement& last = trace.back();
  CellOutcome& outcome = cell.outcome.emplace();
  outcome.score = last.score;
  outcome.achieved = outcome.reached = last.achieved;
  outcome.modules = last.modules;
  outcome.mass = last.mass;
  outcome.design.modules = {{"hinge", {{"proximal", 0.5}, {"distal", last.mass - 0.5}}}};
  outcome.terms = {{"reached", last.achieved ? 350.0 : 0.0}, {"mass", -5.0 * last.mass}};
  outcome.spent.evaluations = cell.key.training.empty() ? cell.key.budget.evaluations : last.evaluations;
  outcome.spent.seconds = kSecondsPerEvaluation * static_cast<double>(outcome.spent.evaluations);
  outcome.stop = "evaluations";
  cell.state = CellState::kDone;
  cell.trace = std::move(trace);
}

// What each solver does on an instance, with a little luck that makes its seeds differ.
std::vector<Improvement> search(const CellKey& key, bool hopeless) {
  const double least = least_mass(key.instance->index);
  const double luck = std::exp(0.3 * Rng{key.seed}.fork(key.label).fork(key.instance->index).normal());
  if (hopeless) return {{.evaluations = 1, .seconds = kSecondsPerEvaluation, .score = -12.0, .mass = 2.2}};
  if (key.label == "agent") return {achieved_with(2, least * (1.0 + 0.03 * luck))};
  return halving(least, (key.label == "slow" ? 8.0 : 1.0) * luck, key.budget.evaluations);
}

CellKey key_of(CellKind kind, const std::string& problem, const std::string& label) {
  CellKey key;
  key.kind = kind;
  key.problem = problem;
  key.label = label;
  return key;
}

}  // namespace

StudyRecord synthetic_study(const SyntheticOptions& options) {
  StudyRecord out;
  out.study.name = "synthetic";
  out.study.hash = "0123456789abcdef";
  out.study.version = "0.0.0";
  out.study.command = "modsearch compare synthetic --out out";
  out.study.compiler = "a compiler";
  out.study.instruction_set = "sse2";
  out.study.solvers = {{"steady", "random", false}, {"slow", "ga", false}, {"agent", "mpdqn", true}};
  out.study.budget.evaluations = 4096;
  out.study.mass_targets = {50, 20, 10, 5, 2, 1, 0.1};
  for (int s = 0; s < options.seeds; ++s) out.study.seeds.push_back(static_cast<std::uint64_t>(s));
  const auto add = [&](CellKey key) -> CellRecord& {
    CellRecord cell;
    cell.id = fmt::format("{:016x}", out.cells.size());
    cell.number = static_cast<std::int64_t>(out.cells.size());
    cell.key = std::move(key);
    out.cells.push_back(std::move(cell));
    return out.cells.back();
  };

  CellRecord& training = add(key_of(CellKind::kTraining, "seed/random_narrow", "agent"));
  training.state = CellState::kDone;
  training.outcome.emplace().spent.evaluations = 20'000;
  training.outcome->spent.seconds = 60.0;
  training.outcome->cpu_seconds = 40.0;
  const std::string trained = training.id;
  for (const char* problem : {"seed/random_narrow", "seed/random_wide"}) {
    ProblemFacts& facts = out.study.problems.emplace_back();
    facts.name = facts.location = problem;
    for (int i = 0; i < options.instances; ++i) {
      const Instance instance{1, static_cast<std::uint64_t>(i)};
      facts.instances.push_back(instance);
      if (options.bounds && out.study.problems.size() == 1) {
        CellKey key = key_of(CellKind::kBound, problem, "bound");
        key.instance = instance;
        CellRecord& bound = add(std::move(key));
        bound.state = CellState::kDone;
        bound.outcome.emplace().bound = Bound{score_of(least_mass(instance.index)), "made up"};
      }
      for (const SolverFacts& solver : out.study.solvers) {
        for (const std::uint64_t seed : out.study.seeds) {
          CellKey key = key_of(CellKind::kRun, problem, solver.label);
          key.instance = instance;
          key.solver = solver.solver;
          key.seed = seed;
          key.budget = out.study.budget;
          if (solver.trained) key.training = trained;
          CellRecord& cell = add(std::move(key));
          const bool last_instance = i == options.instances - 1;
          if (solver.label == "slow" && i == 0 && seed == 0 && out.study.problems.size() == 1) {
            cell.state = CellState::kFailed;
            cell.failure = "killed by signal 11";
            cell.signal = 11;
          } else if (!(solver.label == "slow" && i == 1 && seed == 0 && out.study.problems.size() == 2)) {
            finish(cell, search(cell.key, solver.label == "slow" && last_instance));
          }
        }
      }
    }
  }
  out.study.n_cells = static_cast<std::int64_t>(out.cells.size());
  return out;
}

}  // namespace modsearch::testing
