#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <modsearch/study/study_runs.hpp>
#include <set>

namespace modsearch {
namespace {

bool same(const std::optional<Instance>& a, const std::optional<Instance>& b) {
  if (!a || !b) return !a && !b;
  return a->seed == b->seed && a->index == b->index;
}

InstanceFacts& facts_of(std::vector<InstanceFacts>& instances, const CellKey& key) {
  const auto found = std::find_if(instances.begin(), instances.end(), [&](const InstanceFacts& facts) {
    return facts.problem == key.problem && same(facts.instance, key.instance);
  });
  if (found != instances.end()) return *found;
  instances.push_back({.problem = key.problem, .instance = key.instance});
  return instances.back();
}

// What a cell tells about its instance.
void learn(InstanceFacts& facts, const CellRecord& cell) {
  if (!cell.outcome) return;
  const CellOutcome& outcome = *cell.outcome;
  if (outcome.stop == name(StopReason::kUnreachable)) facts.unreachable = true;
  if (outcome.bound && std::isfinite(outcome.bound->score)) {
    facts.bound = std::min(facts.bound.value_or(INFINITY), outcome.bound->score);
  }
  if (outcome.achieved && (facts.best == nullptr || outcome.score > facts.best->outcome->score)) facts.best = &cell;
}

// Score per kilogram; 0 for a scoring that does not look at mass.
double price_of_mass(const CellOutcome& outcome) {
  const auto term = std::find_if(outcome.terms.begin(), outcome.terms.end(),
                                 [](const TermRecord& candidate) { return candidate.name == "mass"; });
  return term == outcome.terms.end() || outcome.mass <= 0.0 ? 0.0 : std::max(0.0, -term->value / outcome.mass);
}

}  // namespace

std::string_view name(Certainty certainty) {
  switch (certainty) {
    case Certainty::kOptimal:
      return "optimal";
    case Certainty::kBounded:
      return "bounded";
    case Certainty::kUnreachable:
      return "unreachable";
    case Certainty::kNone:
      return "none";
  }
  return "none";
}

std::string InstanceFacts::name() const {
  return instance ? fmt::format("{} {}:{}", problem, instance->seed, instance->index) : problem;
}

Certainty InstanceFacts::certainty() const {
  if (best == nullptr && unreachable) return Certainty::kUnreachable;
  if (!bound) return Certainty::kNone;
  if (best == nullptr) return Certainty::kBounded;
  const CellOutcome& outcome = *best->outcome;
  const double slack = std::max(kCertifiedGap * std::max(1.0, std::abs(*bound)),
                                kCertifiedShare * price_of_mass(outcome) * outcome.mass);
  return *bound - outcome.score <= slack ? Certainty::kOptimal : Certainty::kBounded;
}

std::optional<double> InstanceFacts::reference_score() const {
  if (best == nullptr) return bound;
  return std::max(best->outcome->score, bound.value_or(-INFINITY));
}

int InstanceFacts::reference_modules() const { return best->outcome->modules; }

double InstanceFacts::reference_mass() const {
  const CellOutcome& outcome = *best->outcome;
  const double price = price_of_mass(outcome);
  if (price <= 0.0) return outcome.mass;
  return std::max(0.0, outcome.mass - (*reference_score() - outcome.score) / price);
}

int InstanceFacts::dimension() const {
  if (best == nullptr) return 1;
  std::size_t count = 0;
  for (const DesignRecord::Module& module : best->outcome->design.modules) count += 1 + module.parameters.size();
  return std::max(1, static_cast<int>(count));
}

int StudyRuns::n_runs(std::size_t solver) const {
  std::size_t count = 0;
  for (const auto& of_instance : runs[solver]) count += of_instance.size();
  return static_cast<int>(count);
}

int StudyRuns::n_failed(std::size_t solver) const {
  std::ptrdiff_t count = 0;
  for (const auto& of_instance : runs[solver]) {
    count += std::count_if(of_instance.begin(), of_instance.end(),
                           [](const CellRecord* cell) { return cell->state == CellState::kFailed; });
  }
  return static_cast<int>(count);
}

StudyRuns runs_of(const StudyRecord& record, std::string_view problem) {
  StudyRuns out{.solvers = record.study.solvers};
  const auto wanted = [&](const CellRecord& cell) {
    return cell.key.kind != CellKind::kTraining && (problem.empty() || cell.key.problem == problem);
  };
  // Bounds come before runs in a journal, so that instances are put in the order of the runs' problems either way.
  for (const CellRecord& cell : record.cells) {
    if (wanted(cell)) learn(facts_of(out.instances, cell.key), cell);
  }
  out.runs.assign(out.solvers.size(), std::vector<std::vector<const CellRecord*>>(out.instances.size()));
  for (const CellRecord& cell : record.cells) {
    if (!wanted(cell) || cell.key.kind != CellKind::kRun || cell.state == CellState::kStarted) continue;
    const InstanceFacts& facts = facts_of(out.instances, cell.key);
    const auto solver = std::find_if(out.solvers.begin(), out.solvers.end(),
                                     [&](const SolverFacts& candidate) { return candidate.label == cell.key.label; });
    if (solver == out.solvers.end() || facts.certainty() == Certainty::kUnreachable) continue;
    out.runs[static_cast<std::size_t>(solver - out.solvers.begin())]
            [static_cast<std::size_t>(&facts - out.instances.data())]
                .push_back(&cell);
  }
  for (auto& of_solver : out.runs) {
    for (auto& of_instance : of_solver) {
      std::stable_sort(of_instance.begin(), of_instance.end(),
                       [](const CellRecord* a, const CellRecord* b) { return a->key.seed < b->key.seed; });
    }
  }
  return out;
}

std::optional<TrainingCost> training_cost(const StudyRecord& record, const StudyRuns& runs, std::size_t solver) {
  std::set<std::string> ids;
  for (const auto& of_instance : runs.runs[solver]) {
    for (const CellRecord* cell : of_instance) {
      if (!cell->key.training.empty()) ids.insert(cell->key.training);
    }
  }
  std::map<std::string, TrainingCost> by_family;
  for (const std::string& id : ids) {
    const CellRecord* training = record.find(id);
    if (training == nullptr || !training->outcome) continue;
    TrainingCost& sum = by_family[training->key.problem];
    sum.evaluations += static_cast<double>(training->outcome->spent.evaluations);
    sum.seconds += training->outcome->cpu_seconds;
    ++sum.trainings;
  }
  if (by_family.empty()) return std::nullopt;
  TrainingCost out;
  for (const auto& [problem, sum] : by_family) {
    out.evaluations += sum.evaluations / sum.trainings;
    out.seconds += sum.seconds / sum.trainings;
    out.trainings += sum.trainings;
  }
  return out;
}

}  // namespace modsearch
