#include "app/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace modsearch::app {
namespace {

// Share of the budget that is spent, by whichever limit is nearest; 0 where there is none.
double spent_share(const Budget& budget, const Progress& progress) {
  const double by_time = std::isfinite(budget.seconds) ? progress.seconds / budget.seconds : 0.0;
  const double by_count = static_cast<double>(progress.evaluations) / static_cast<double>(budget.evaluations);
  return std::clamp(std::max(by_time, by_count), 0.0, 1.0);
}

std::string best_so_far(const Meter& meter) {
  if (!meter.best()) return "no design yet";
  const Evaluation& evaluation = meter.best()->evaluation;
  return fmt::format("best {:.4f}{}", evaluation.score, evaluation.attempt.achieved ? "" : " (not achieved)");
}

}  // namespace

ProgressDisplay::ProgressDisplay(std::string what, bool quiet) : what_{std::move(what)}, line_{quiet} {}

void ProgressDisplay::update(const Meter& meter) {
  constexpr int kCallsPerLook = 16;
  if (line_.quiet() || ++calls_ % kCallsPerLook != 0 || !line_.due()) return;
  const Progress progress = meter.progress();
  const double share = spent_share(meter.budget(), progress);
  const double rate = static_cast<double>(progress.evaluations) / std::max(progress.seconds, 1e-9);
  const std::string left =
      share > 0.01 ? fmt::format(", at most {:.0f} s left", progress.seconds * (1.0 / share - 1.0)) : "";
  line_.show(share, fmt::format("{}: {} evaluations, {:.0f}/s, {:.1f} s{}, {}", what_, progress.evaluations, rate,
                                progress.seconds, left, best_so_far(meter)));
}

}  // namespace modsearch::app
