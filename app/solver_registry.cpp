#include "app/solver_registry.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <modsearch/baselines/annealing.hpp>
#include <modsearch/baselines/auto_solver.hpp>
#include <modsearch/baselines/branch_and_bound.hpp>
#include <modsearch/baselines/cma_es.hpp>
#include <modsearch/baselines/eliminate.hpp>
#include <modsearch/baselines/enumerate.hpp>
#include <modsearch/baselines/genetic_algorithm.hpp>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/baselines/pose_first.hpp>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/baselines/tree_search.hpp>
#include <modsearch/rl/random_policy.hpp>
#include <modsearch/rl/saved_policy.hpp>
#include <stdexcept>

#include "app/name_and_options.hpp"

namespace modsearch::app {
namespace {

std::string value_or(const OptionValues& values, const std::string& key, const std::string& otherwise) {
  const auto found = values.find(key);
  return found == values.end() ? otherwise : found->second;
}

int integer(const OptionValues& values, const std::string& key, int otherwise, int least, int most) {
  const auto found = values.find(key);
  if (found == values.end()) return otherwise;
  const std::string& text = found->second;
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < least || value > most) {
    throw std::invalid_argument(fmt::format("option {}={}: not an integer in [{}, {}]", key, text, least, most));
  }
  return value;
}

double number(const OptionValues& values, const std::string& key, double otherwise) {
  const auto found = values.find(key);
  if (found == values.end()) return otherwise;
  const std::string& text = found->second;
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    throw std::invalid_argument(fmt::format("option {}={}: not a number", key, text));
  }
  return value;
}

std::string inner_names() {
  std::vector<std::string_view> names;
  for (const Inner inner : inner_solvers()) names.push_back(name(inner));
  return fmt::format("{}", fmt::join(names, "|"));
}

Inner inner_solver(const OptionValues& values, Inner otherwise) {
  const std::string inner = value_or(values, "inner", std::string{name(otherwise)});
  const std::optional<Inner> known = inner_from_name(inner);
  if (!known) throw std::invalid_argument(fmt::format("option inner={}: not one of {}", inner, inner_names()));
  return *known;
}

std::unique_ptr<Solver> make_random(const OptionValues& values) {
  const int proposals = integer(values, "polish", 0, 0, 1'000'000);
  if (proposals == 0) return std::make_unique<RandomSearch>();
  RandomPolicyOptions options;
  options.proposals = proposals;
  options.polishing.descend_mass = integer(values, "mass", 0, 0, 1) == 1;
  options.type = value_or(values, "type", options.type);
  return std::make_unique<RandomPolicy>(options);
}

SolverEntry random_entry() {
  return {"random",
          "uniform over number of modules, types and parameters: the bar to clear",
          {{"polish", "0", "K > 0: instead a policy of random modules, the best of K polished ones at each placement"},
           {"mass", "0", "1: polish goes on to the lightest parameters that reach"},
           {"type", "any", "with polish: proposes modules with this ID only"}},
          make_random};
}

std::unique_ptr<Solver> make_per_sequence(const OptionValues& values) {
  PerSequenceOptions options;
  options.inner = inner_solver(values, options.inner);
  options.starts = integer(values, "starts", options.starts, 1, 100'000);
  return std::make_unique<PerSequence>(options);
}

std::unique_ptr<Solver> make_genetic_algorithm(const OptionValues& values) {
  GeneticOptions options;
  options.population = integer(values, "population", options.population, 2, 1'000'000);
  options.tournament = integer(values, "tournament", options.tournament, 1, 1'000'000);
  options.crossover = number(values, "crossover", options.crossover);
  options.structure = number(values, "structure", options.structure);
  options.step = number(values, "step", options.step);
  options.precision = integer(values, "precision", options.precision, 0, 50);
  options.polish = integer(values, "polish", options.polish, 0, 1'000'000);
  options.inner = inner_solver(values, options.inner);
  return std::make_unique<GeneticAlgorithm>(options);
}

SolverEntry genetic_algorithm() {
  const GeneticOptions defaults;
  return {"ga",
          "lexicographic genetic algorithm: cheap tests first, species by number of modules, best designs polished",
          {{"population", std::to_string(defaults.population), "designs per generation"},
           {"tournament", std::to_string(defaults.tournament), "contestants for each parent"},
           {"crossover", fmt::format("{}", defaults.crossover), "share of children with two parents"},
           {"structure", fmt::format("{}", defaults.structure), "share of children with another sequence"},
           {"step", fmt::format("{}", defaults.step), "largest change of a length, share of its interval"},
           {"precision", std::to_string(defaults.precision), "smallest change is 2^-precision of that"},
           {"polish", std::to_string(defaults.polish), "designs polished per generation; 0: pure evolution"},
           {"inner", std::string{name(defaults.inner)}, inner_names()}},
          make_genetic_algorithm};
}

std::unique_ptr<Solver> make_cma_es(const OptionValues& values) {
  CmaEsOptions options;
  const std::string space = value_or(values, "space", std::string{name(options.space)});
  const auto known = space_from_name(space);
  if (!known) throw std::invalid_argument(fmt::format("option space={}: not one of lengths|padded", space));
  options.space = *known;
  options.population = integer(values, "population", options.population, 0, 10'000);
  options.growth = number(values, "growth", options.growth);
  options.sigma = number(values, "sigma", options.sigma);
  options.least_sigma = number(values, "least_sigma", options.least_sigma);
  return std::make_unique<CmaEs>(options);
}

SolverEntry cma_es() {
  const CmaEsOptions defaults;
  return {
      "cmaes",
      "CMA-ES with margin over types and lengths (CatCMA), restarted with larger populations",
      {{"space", std::string{name(defaults.space)}, "lengths: a search per number of modules; padded: one for all"},
       {"population", std::to_string(defaults.population), "points per generation at first; 0: 4 + 3 ln(variables)"},
       {"growth", fmt::format("{}", defaults.growth), "population of a round over that of the round before"},
       {"sigma", fmt::format("{}", defaults.sigma), "first standard deviation, share of a length's interval"},
       {"least_sigma", fmt::format("{}", defaults.least_sigma), "ends a search, share of a length's interval"}},
      make_cma_es};
}

SolverEntry pose_first() {
  const PoseFirstOptions defaults;
  return {
      "pose-first",
      "sequences from a model that learns; all poses and lengths at once, clearance when needed: for several full "
      "poses",
      {{"starts", std::to_string(defaults.starts), "of a new sequence"},
       {"iterations", std::to_string(defaults.iterations), "of the smooth program that makes room and takes off mass"}},
      [](const OptionValues& values) {
        PoseFirstOptions options;
        options.starts = integer(values, "starts", options.starts, 1, 100'000);
        options.iterations = integer(values, "iterations", options.iterations, 1, 100'000);
        return std::make_unique<PoseFirst>(options);
      }};
}

std::unique_ptr<Solver> make_annealing(const OptionValues& values) {
  AnnealingOptions options;
  options.cycle = integer(values, "cycle", options.cycle, 1, 1'000'000'000);
  options.hot = number(values, "hot", options.hot);
  options.cold = number(values, "cold", options.cold);
  options.structure = number(values, "structure", options.structure);
  options.penalty = number(values, "penalty", options.penalty);
  return std::make_unique<SimulatedAnnealing>(options);
}

SolverEntry annealing() {
  const AnnealingOptions defaults;
  return {
      "anneal",
      "simulated annealing: one design, changed module by module and length by length, cooled and heated again",
      {{"cycle", std::to_string(defaults.cycle), "evaluations from hot to cold"},
       {"hot", fmt::format("{}", defaults.hot), "first temperature, points of the score"},
       {"cold", fmt::format("{}", defaults.cold), "last temperature, points of the score"},
       {"structure", fmt::format("{}", defaults.structure), "share of proposals with another sequence"},
       {"penalty", fmt::format("{}", defaults.penalty), "points for missing a goal by its whole distance, at first"}},
      make_annealing};
}

std::unique_ptr<Solver> make_enumerate(const OptionValues& values) {
  EnumerateOptions options;
  options.continuous.starts = integer(values, "starts", options.continuous.starts, 1, 100'000);
  options.samples = integer(values, "samples", options.samples, 1, 1'000'000);
  return std::make_unique<Enumerate>(options);
}

SolverEntry enumeration() {
  const EnumerateOptions defaults;
  return {
      "enumerate",
      "best-first over type sequences with an admissible bound; proves the optimum where modules have no parameters",
      {{"starts", std::to_string(defaults.continuous.starts), "low-discrepancy starts per sequence"},
       {"samples", std::to_string(defaults.samples),
        "random designs of a sequence that has parameters and no smooth program"}},
      make_enumerate};
}

SolverEntry branch_and_bound() {
  return {"branch-and-bound",
          "certified: all sequences, lengths and postures at once, until none can score more but for the gap",
          {{"gap", fmt::format("{}", BranchAndBoundOptions{}.gap), "share of the mass that may be left open"}},
          [](const OptionValues& values) {
            return std::make_unique<BranchAndBound>(
                BranchAndBoundOptions{.gap = number(values, "gap", BranchAndBoundOptions{}.gap)});
          }};
}

SolverEntry elimination() {
  const EliminateOptions defaults;
  return {
      "eliminate",
      "hierarchical elimination: connectors, reach, score, poses, bodies, path, and how many each stage removes",
      {{"grid", std::to_string(defaults.grid), "values that each parameter takes, from its lower to its upper end"}},
      [](const OptionValues& values) {
        return std::make_unique<Eliminate>(
            EliminateOptions{.grid = integer(values, "grid", EliminateOptions{}.grid, 1, 1000)});
      }};
}

std::unique_ptr<Solver> make_tree_search(const OptionValues& values) {
  TreeSearchOptions options;
  options.exploration = number(values, "exploration", options.exploration);
  options.width = number(values, "width", options.width);
  options.growth = number(values, "growth", options.growth);
  options.uniform = number(values, "uniform", options.uniform);
  options.rollout = integer(values, "rollout", options.rollout ? 1 : 0, 0, 1) != 0;
  options.polish = integer(values, "polish", options.polish, 0, 1'000'000);
  options.inner = inner_solver(values, options.inner);
  return std::make_unique<TreeSearch>(options);
}

SolverEntry tree_search() {
  const TreeSearchOptions defaults;
  return {
      "mcts",
      "Monte-Carlo tree search that grows designs module by module, lengths by Voronoi optimistic optimisation",
      {{"exploration", fmt::format("{}", defaults.exploration), "c of UCT, for values in [0, 1]"},
       {"width", fmt::format("{}", defaults.width), "lengths tried of a type chosen n times: width n^growth"},
       {"growth", fmt::format("{}", defaults.growth), "see width"},
       {"uniform", fmt::format("{}", defaults.uniform), "share of new lengths from the whole box"},
       {"rollout", defaults.rollout ? "1" : "0", "1: continue new designs at random"},
       {"polish", std::to_string(defaults.polish), "most steps of the smooth program on the best of a type; 0: none"},
       {"inner", std::string{name(defaults.inner)}, inner_names()}},
      make_tree_search};
}

std::vector<SolverEntry> make_entries() {
  const PerSequenceOptions defaults;
  std::vector<SolverEntry> entries;
  entries.push_back({"auto",
                     "the default: bounds first, then what suits the problem: eliminate, per-sequence, pose-first or "
                     "ga; says what is proved",
                     {},
                     [](const OptionValues&) { return std::make_unique<AutoSolver>(); }});
  entries.push_back(random_entry());
  entries.push_back({"per-sequence",
                     "type sequences in order of an optimistic bound, each solved as a smooth program",
                     {{"inner", std::string{name(defaults.inner)}, inner_names()},
                      {"starts", std::to_string(defaults.starts), "low-discrepancy starts per sequence"}},
                     make_per_sequence});
  entries.push_back(pose_first());
  entries.push_back(enumeration());
  entries.push_back(branch_and_bound());
  entries.push_back(elimination());
  entries.push_back(tree_search());
  entries.push_back(genetic_algorithm());
  entries.push_back(cma_es());
  entries.push_back(annealing());
  return entries;
}

const SolverEntry& entry_named(const std::string& name) {
  const std::vector<SolverEntry>& entries = solver_entries();
  const auto found =
      std::find_if(entries.begin(), entries.end(), [&](const auto& entry) { return entry.name == name; });
  if (found != entries.end()) return *found;
  std::vector<std::string> known;
  for (const SolverEntry& entry : entries) known.push_back(entry.name);
  known.push_back("policy:FILE");
  throw std::invalid_argument(fmt::format("solver '{}' is not one of {}", name, fmt::join(known, ", ")));
}

}  // namespace

const std::vector<SolverEntry>& solver_entries() {
  static const std::vector<SolverEntry> entries = make_entries();
  return entries;
}

ChosenSolver choose_solver(const std::string& text) {
  constexpr std::string_view kPolicy = "policy:";
  if (text.starts_with(kPolicy)) {
    const std::string file = text.substr(kPolicy.size());
    return {load_trained_policy(file), "policy", {{"file", file}}};
  }
  const NameAndOptions parsed = parse_name_and_options(text, "solver");
  const SolverEntry& entry = entry_named(parsed.name);
  OptionValues values;
  for (const auto& [key, value] : parsed.options) {
    const bool known = std::any_of(entry.options.begin(), entry.options.end(),
                                   [&key = key](const OptionEntry& option) { return option.key == key; });
    if (!known) {
      std::vector<std::string> keys;
      for (const OptionEntry& option : entry.options) keys.push_back(option.key);
      throw std::invalid_argument(
          keys.empty()
              ? fmt::format("solver '{}' has no option '{}' (it has none)", parsed.name, key)
              : fmt::format("solver '{}' has no option '{}', only {}", parsed.name, key, fmt::join(keys, ", ")));
    }
    values.emplace(key, value);
  }
  return {entry.make(values), parsed.name, parsed.options};
}

}  // namespace modsearch::app
