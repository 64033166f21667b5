#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/study/targets.hpp>

namespace modsearch {
namespace {

bool meets(const Improvement& found, const InstanceFacts& instance, const Target& target) {
  if (!found.achieved) return false;
  switch (target.kind) {
    case Target::Kind::kAchieved:
      return true;
    case Target::Kind::kFewestModules:
      return instance.best != nullptr && found.modules <= instance.reference_modules();
    case Target::Kind::kMass: {
      // The slack lets a design count that is as heavy as the reference, which was computed from scores.
      constexpr double slack = 1e-9;
      return instance.best != nullptr && found.modules <= instance.reference_modules() &&
             found.mass <= (1.0 + target.percent / 100.0) * instance.reference_mass() + slack;
    }
  }
  return false;
}

double spent_at(const Improvement& found, Measure measure) {
  return measure == Measure::kEvaluations ? static_cast<double>(found.evaluations) : found.seconds;
}

double spent_by(const CellRecord& run, Measure measure) {
  if (run.outcome) {
    const Progress& spent = run.outcome->spent;
    return measure == Measure::kEvaluations ? static_cast<double>(spent.evaluations) : spent.seconds;
  }
  if (measure == Measure::kEvaluations) return static_cast<double>(run.key.budget.evaluations);
  return std::isfinite(run.key.budget.seconds) ? run.key.budget.seconds : 0.0;
}

}  // namespace

std::string Target::name() const {
  switch (kind) {
    case Kind::kAchieved:
      return "achieved";
    case Kind::kFewestModules:
      return "fewest modules";
    case Kind::kMass:
      return fmt::format("mass within {:g} %", percent);
  }
  return "";
}

std::vector<Target> targets_of(const StudyFacts& study) {
  std::vector<Target> out{{Target::Kind::kAchieved}, {Target::Kind::kFewestModules}};
  for (const double percent : study.mass_targets) out.push_back({Target::Kind::kMass, percent});
  return out;
}

std::string_view name(Measure measure) { return measure == Measure::kEvaluations ? "evaluations" : "seconds"; }

TargetRun target_run(const CellRecord& run, const InstanceFacts& instance, const Target& target, Measure measure) {
  for (const Improvement& found : run.trace) {
    if (meets(found, instance, target)) return {spent_at(found, measure), true};
  }
  return {spent_by(run, measure), false};
}

double regret(const CellRecord& run, const InstanceFacts& instance) {
  const std::optional<double> reference = instance.reference_score();
  if (!run.outcome || !run.outcome->achieved || !reference) return INFINITY;
  return *reference - run.outcome->score;
}

double regret_after(const CellRecord& run, const InstanceFacts& instance, Measure measure, double spent) {
  const std::optional<double> reference = instance.reference_score();
  double out = INFINITY;
  for (const Improvement& found : run.trace) {
    if (spent_at(found, measure) > spent) break;
    if (found.achieved && reference) out = *reference - found.score;
  }
  return out;
}

std::vector<TargetRun> target_runs(const StudyRuns& runs, std::size_t solver, const Target& target, Measure measure) {
  std::vector<TargetRun> out;
  for (std::size_t i = 0; i < runs.instances.size(); ++i) {
    for (const CellRecord* run : runs.runs[solver][i]) {
      out.push_back(target_run(*run, runs.instances[i], target, measure));
    }
  }
  return out;
}

Strata regrets(const StudyRuns& runs, std::size_t solver) {
  Strata out;
  for (std::size_t i = 0; i < runs.instances.size(); ++i) {
    std::vector<double> of_instance;
    for (const CellRecord* run : runs.runs[solver][i]) of_instance.push_back(regret(*run, runs.instances[i]));
    if (!of_instance.empty()) out.push_back(std::move(of_instance));
  }
  return out;
}

PairedRuntimes paired_runtimes(const StudyRuns& runs, const Target& target, Measure measure) {
  PairedRuntimes out{.runtimes = RuntimeTable(runs.solvers.size())};
  if (runs.solvers.empty()) return out;
  for (std::size_t i = 0; i < runs.instances.size(); ++i) {
    for (const CellRecord* first : runs.runs[0][i]) {
      std::vector<double> pair;
      for (std::size_t s = 0; s < runs.solvers.size(); ++s) {
        const auto& of_solver = runs.runs[s][i];
        const auto twin = std::find_if(of_solver.begin(), of_solver.end(), [&](const CellRecord* candidate) {
          return candidate->key.seed == first->key.seed;
        });
        if (twin == of_solver.end()) break;
        pair.push_back(target_run(**twin, runs.instances[i], target, measure).runtime());
      }
      if (pair.size() < runs.solvers.size()) continue;
      for (std::size_t s = 0; s < pair.size(); ++s) out.runtimes[s].push_back(pair[s]);
      out.dimensions.push_back(runs.instances[i].dimension());
    }
  }
  return out;
}

}  // namespace modsearch
