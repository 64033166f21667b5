#include <algorithm>
#include <cmath>
#include <modsearch/study/curves.hpp>

namespace modsearch {

StepFunction runtime_distribution(const StudyRuns& runs, std::size_t solver, const std::vector<Target>& targets,
                                  Measure measure, double training) {
  std::vector<double> runtimes;
  for (const Target& target : targets) {
    for (const TargetRun& run : target_runs(runs, solver, target, measure))
      runtimes.push_back(run.runtime() + training);
  }
  return runtimes.empty() ? StepFunction{} : empirical_distribution(runtimes);
}

Convergence convergence(const StudyRuns& runs, std::size_t solver, Measure measure, int points) {
  double first = INFINITY, last = 0.0;
  for (const auto& of_instance : runs.runs[solver]) {
    for (const CellRecord* run : of_instance) {
      if (!run->outcome) continue;
      for (const Improvement& found : run->trace) {
        const double spent = measure == Measure::kEvaluations ? static_cast<double>(found.evaluations) : found.seconds;
        if (spent > 0.0) first = std::min(first, spent);
      }
      const Progress& spent = run->outcome->spent;
      last = std::max(last, measure == Measure::kEvaluations ? static_cast<double>(spent.evaluations) : spent.seconds);
    }
  }
  Convergence out;
  if (!(first <= last)) return out;
  for (int i = 0; i < points; ++i) {
    const double share = points == 1 ? 1.0 : static_cast<double>(i) / (points - 1);
    // Whole evaluations; the last point is the end itself, which rounding of the power would miss.
    double spent = i == points - 1 ? last : first * std::pow(last / first, share);
    if (measure == Measure::kEvaluations) spent = std::ceil(spent);
    if (!out.spent.empty() && spent <= out.spent.back()) continue;
    std::vector<double> regrets;
    for (std::size_t instance = 0; instance < runs.instances.size(); ++instance) {
      for (const CellRecord* run : runs.runs[solver][instance]) {
        regrets.push_back(regret_after(*run, runs.instances[instance], measure, spent));
      }
    }
    out.spent.push_back(spent);
    out.low.push_back(quantile(regrets, 0.25));
    out.median.push_back(quantile(regrets, 0.5));
    out.high.push_back(quantile(std::move(regrets), 0.75));
  }
  return out;
}

}  // namespace modsearch
