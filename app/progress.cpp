#include "app/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/report_internal.hpp"

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

std::string progress_text(const std::string& what, const Meter& meter) {
  const Progress progress = meter.progress();
  const double share = spent_share(meter.budget(), progress);
  const double rate = static_cast<double>(progress.evaluations) / std::max(progress.seconds, 1e-9);
  constexpr std::size_t kReasons = 3;
  const std::string failures = failures_text(progress, kReasons);
  std::string text = fmt::format("{}: {}", what, best_so_far(meter));
  if (!meter.stage().empty()) text += fmt::format("; {}", meter.stage());
  text += fmt::format("; {} evaluations, {:.0f}/s, {:.1f} s", progress.evaluations, rate, progress.seconds);
  if (share > 0.01) text += fmt::format(", at most {:.0f} s left", progress.seconds * (1.0 / share - 1.0));
  if (!failures.empty()) text += fmt::format("; failed: {}", failures);
  return text;
}

ProgressDisplay::ProgressDisplay(std::string what, bool quiet, const ModuleLibrary* library)
    : what_{std::move(what)}, line_{quiet}, library_{library} {}

void ProgressDisplay::update(const Meter& meter) {
  if (line_.quiet()) return;
  if (library_ != nullptr) tell_first_achieved(meter);
  constexpr int kCallsPerLook = 16;
  const bool new_stage = meter.stage() != stage_;
  if ((!new_stage && ++calls_ % kCallsPerLook != 0) || !line_.due()) return;
  stage_ = meter.stage();
  line_.show(spent_share(meter.budget(), meter.progress()), progress_text(what_, meter));
}

void ProgressDisplay::tell_first_achieved(const Meter& meter) {
  if (!meter.best() || !meter.best()->evaluation.attempt.achieved) return;
  const TracePoint& found = meter.trace().back();
  line_.say(
      fmt::format("{}: first achieved design after {:.3f} s and {} evaluations, score {:.4f}: {}; the search goes on",
                  what_, found.seconds, found.evaluations, found.score, to_string(*library_, meter.best()->design)));
  library_ = nullptr;
}

}  // namespace modsearch::app
