#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <modsearch/rl/float_kernels.hpp>
#include <modsearch/study/study.hpp>
#include <modsearch/study/text_hash.hpp>
#include <set>
#include <stdexcept>

namespace modsearch {
namespace {

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument("study: " + what); }

template <typename Items, typename Name>
void check_names(const Items& items, const char* what, Name name_of) {
  if (items.empty()) refuse(fmt::format("no {} (at least 1)", what));
  std::set<std::string> names;
  for (const auto& item : items) {
    const std::string& text = name_of(item);
    if (text.empty()) refuse(fmt::format("a {} without a name", what));
    if (!names.insert(text).second) refuse(fmt::format("{} '{}' occurs twice", what, text));
  }
}

constexpr std::uint64_t kLastNumber = std::numeric_limits<std::uint64_t>::max();

// Whether `count` numbers from `first` on are there: a sum that wraps would give others.
bool fits(std::uint64_t first, int count) { return static_cast<std::uint64_t>(count) - 1 <= kLastNumber - first; }

void check(const StudyProblem& problem) {
  if (!problem.make) refuse(fmt::format("problem '{}' has nothing that makes it", problem.name));
  if (problem.instances && problem.instances->count < 1) {
    refuse(fmt::format("problem '{}': {} instances (at least 1)", problem.name, problem.instances->count));
  }
  if (problem.instances && !fits(problem.instances->first, problem.instances->count)) {
    refuse(fmt::format("problem '{}': {} instances from {} on (no number may be above {})", problem.name,
                       problem.instances->count, problem.instances->first, kLastNumber));
  }
}

void check(const StudySolver& solver) {
  if (solver.text.empty()) refuse(fmt::format("solver '{}' has no text that names it and its options", solver.label));
  if ((solver.solver != nullptr) != solver.trainings.empty()) {
    refuse(fmt::format("solver '{}' is either given or trained", solver.label));
  }
  for (const StudyTraining& training : solver.trainings) {
    if (training.seeds.empty()) refuse(fmt::format("solver '{}': no seed of a training", solver.label));
    if (!training.source || !training.library) {
      refuse(fmt::format("solver '{}': no problems or no library to train on", solver.label));
    }
  }
}

bool has_control_characters(const std::string& text) {
  return std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; });
}

void check(const Study& study) {
  if (study.name.empty()) refuse("it has no name");
  check_names(study.problems, "problem",
              [](const StudyProblem& problem) -> const std::string& { return problem.name; });
  check_names(study.solvers, "solver", [](const StudySolver& solver) -> const std::string& { return solver.label; });
  for (const StudyProblem& problem : study.problems) check(problem);
  for (const StudySolver& solver : study.solvers) {
    check(solver);
    // Tables have a line per solver.
    if (has_control_characters(solver.label))
      refuse("a solver whose label has line breaks or other control characters");
  }
  if (study.seeds.empty()) refuse("no seed (at least 1)");
  if (std::set<std::uint64_t>{study.seeds.begin(), study.seeds.end()}.size() != study.seeds.size()) {
    refuse("a seed occurs twice");
  }
  static_cast<void>(Meter{study.budget});  // refuses what is no budget
  for (const double share : study.mass_targets) {
    if (!(share > 0.0) || !std::isfinite(share)) refuse(fmt::format("a target of {} % of the mass (above 0)", share));
  }
  if (study.certification && !study.certification->solver) refuse("nothing that certifies");
}

std::vector<std::optional<Instance>> instances_of(const StudyProblem& problem) {
  if (!problem.instances) return {std::nullopt};
  std::vector<std::optional<Instance>> instances;
  for (int i = 0; i < problem.instances->count; ++i) {
    instances.emplace_back(Instance{problem.instances->seed, problem.instances->first + static_cast<std::uint64_t>(i)});
  }
  return instances;
}

// Key by key, in a fixed order, one line each: what is hashed.
std::string canonical(const CellKey& key) {
  std::string text = fmt::format("kind={}\nproblem={}\n", name(key.kind), key.problem);
  if (key.instance) text += fmt::format("instance={}:{}\n", key.instance->seed, key.instance->index);
  text += fmt::format("solver={}\nseed={}\nevaluations={}\nseconds={}\n", key.solver, key.seed, key.budget.evaluations,
                      key.budget.seconds);
  if (!key.training.empty()) text += fmt::format("training={}\n", key.training);
  return text;
}

std::string settings_text(const LearnerSettings& settings) {
  std::string text = fmt::format("agent={}\n", name(settings.kind));
  for (const Setting& setting : setting_table()) text += fmt::format("{}={}\n", setting.key, setting.get(settings));
  return text;
}

std::string canonical(const Study& study) {
  std::string text;
  for (const PlannedCell& cell : cells_of(study)) text += fmt::format("{} {}\n", cell.record.id, cell.record.key.label);
  for (const StudyProblem& problem : study.problems) text += fmt::format("{}\n{}\n", problem.name, problem.content);
  for (const StudySolver& solver : study.solvers) {
    for (const StudyTraining& training : solver.trainings) text += settings_text(training.settings);
  }
  return text + fmt::format("{}\n{}\n", study.name, fmt::join(study.mass_targets, ","));
}

// Collects cells and refuses one that is there already.
class CellList {
 public:
  std::size_t add(CellKey key, PlannedCell cell) {
    const std::string id = cell_id(key);
    const std::size_t number = cells_.size();
    const auto [place, is_new] = numbers_.emplace(id, number);
    if (!is_new) {
      const CellKey& other = cells_[place->second].record.key;
      refuse(
          fmt::format("solvers '{}' and '{}' are the same on {}: {}", other.label, key.label, key.problem, key.solver));
    }
    cell.record.id = id;
    cell.record.number = static_cast<std::int64_t>(number);
    cell.record.key = std::move(key);
    cells_.push_back(std::move(cell));
    return number;
  }
  // The number of the same training where an earlier solver has it: two may use one policy.
  std::size_t add_training(CellKey key, PlannedCell cell, const Study& study) {
    const auto found = numbers_.find(cell_id(key));
    if (found == numbers_.end()) return add(std::move(key), std::move(cell));
    const PlannedCell& other = cells_[found->second];
    const auto settings = [&](const PlannedCell& of) {
      return settings_text(study.solvers[of.solver].trainings[of.training].settings);
    };
    return other.solver != cell.solver && settings(other) == settings(cell) ? found->second
                                                                            : add(std::move(key), std::move(cell));
  }
  [[nodiscard]] const std::string& id(std::size_t number) const { return cells_[number].record.id; }
  [[nodiscard]] std::vector<PlannedCell> cells() && { return std::move(cells_); }

 private:
  std::vector<PlannedCell> cells_;
  std::map<std::string, std::size_t> numbers_;
};

// Numbers of the cells of each training of each solver, by its seeds: [n_solvers][n_trainings][n_seeds].
using TrainingNumbers = std::vector<std::vector<std::vector<std::size_t>>>;

TrainingNumbers add_trainings(const Study& study, CellList& cells) {
  TrainingNumbers numbers(study.solvers.size());
  for (std::size_t s = 0; s < study.solvers.size(); ++s) {
    const StudySolver& solver = study.solvers[s];
    for (std::size_t t = 0; t < solver.trainings.size(); ++t) {
      std::vector<std::size_t>& by_seed = numbers[s].emplace_back();
      for (const std::uint64_t seed : solver.trainings[t].seeds) {
        by_seed.push_back(cells.add_training({.kind = CellKind::kTraining,
                                              .problem = solver.trainings[t].problem,
                                              .instance = std::nullopt,
                                              .label = solver.label,
                                              .solver = solver.text,
                                              .seed = seed,
                                              .budget = {.evaluations = std::numeric_limits<std::int64_t>::max()},
                                              .training = {}},
                                             {.record = {}, .solver = s, .training = t}, study));
      }
    }
  }
  return numbers;
}

// Which of a solver's trainings belongs to a problem.
std::size_t training_for(const StudySolver& solver, const std::string& problem) {
  const auto own = std::find_if(solver.trainings.begin(), solver.trainings.end(),
                                [&](const StudyTraining& training) { return training.problem == problem; });
  return own == solver.trainings.end() ? 0 : static_cast<std::size_t>(own - solver.trainings.begin());
}

void add_bounds(const Study& study, CellList& cells) {
  if (!study.certification) return;
  for (std::size_t p = 0; p < study.problems.size(); ++p) {
    for (const std::optional<Instance>& instance : instances_of(study.problems[p])) {
      cells.add({.kind = CellKind::kBound,
                 .problem = study.problems[p].name,
                 .instance = instance,
                 .label = "bound",
                 .solver = study.certification->text,
                 .seed = 0,
                 .budget = study.certification->budget,
                 .training = {}},
                {.record = {}, .problem = p});
    }
  }
}

}  // namespace

std::string cell_id(const CellKey& key) { return text_hash(canonical(key)); }

std::vector<PlannedCell> cells_of(const Study& study) {
  check(study);
  CellList cells;
  const TrainingNumbers trainings = add_trainings(study, cells);
  add_bounds(study, cells);
  for (std::size_t p = 0; p < study.problems.size(); ++p) {
    for (const std::optional<Instance>& instance : instances_of(study.problems[p])) {
      for (std::size_t s = 0; s < study.solvers.size(); ++s) {
        for (std::size_t i = 0; i < study.seeds.size(); ++i) {
          CellKey key{.kind = CellKind::kRun,
                      .problem = study.problems[p].name,
                      .instance = instance,
                      .label = study.solvers[s].label,
                      .solver = study.solvers[s].text + (study.solvers[s].refine ? " refine" : ""),
                      .seed = study.seeds[i],
                      .budget = study.budget,
                      .training = {}};
          std::optional<std::size_t> needs;
          if (!trainings[s].empty()) {
            const auto& by_seed = trainings[s][training_for(study.solvers[s], study.problems[p].name)];
            needs = by_seed[i % by_seed.size()];
            key.training = cells.id(*needs);
          }
          cells.add(std::move(key), {.record = {}, .problem = p, .solver = s, .needs = needs});
        }
      }
    }
  }
  return std::move(cells).cells();
}

StudyFacts facts_of(const Study& study, const std::string& command) {
  StudyFacts facts;
  facts.name = study.name;
  facts.hash = text_hash(canonical(study));
  facts.version = MODSEARCH_VERSION;
  facts.command = command;
  facts.compiler = MODSEARCH_COMPILER;
  facts.instruction_set = kernel_isa();
  facts.n_cells = static_cast<std::int64_t>(cells_of(study).size());
  for (const StudyProblem& problem : study.problems) {
    ProblemFacts& known = facts.problems.emplace_back(ProblemFacts{problem.name, problem.location, {}});
    if (!problem.instances) continue;
    for (const std::optional<Instance>& instance : instances_of(problem)) known.instances.push_back(*instance);
  }
  for (const StudySolver& solver : study.solvers) {
    facts.solvers.push_back({solver.label, solver.text, !solver.trainings.empty()});
  }
  facts.seeds = study.seeds;
  facts.budget = study.budget;
  facts.mass_targets = study.mass_targets;
  return facts;
}

}  // namespace modsearch
