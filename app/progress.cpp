#include "app/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/terminal.hpp"

namespace modsearch::app {
namespace {

using Clock = std::chrono::steady_clock;

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

ProgressDisplay::ProgressDisplay(std::string what, bool quiet)
    : what_{std::move(what)}, quiet_{quiet}, terminal_{isatty(STDERR_FILENO) == 1}, last_{Clock::now()} {}

ProgressDisplay::~ProgressDisplay() { finish(); }

void ProgressDisplay::update(const Meter& meter) {
  constexpr int kCallsPerLook = 16;
  if (quiet_ || ++calls_ % kCallsPerLook != 0) return;
  const auto now = Clock::now();
  const auto period = terminal_ ? std::chrono::milliseconds{100} : std::chrono::milliseconds{5000};
  if (now - last_ < period) return;
  last_ = now;
  show(meter);
}

void ProgressDisplay::show(const Meter& meter) {
  const Progress progress = meter.progress();
  const double share = spent_share(meter.budget(), progress);
  const double rate = static_cast<double>(progress.evaluations) / std::max(progress.seconds, 1e-9);
  const std::string left = share > 0.01 ? fmt::format(", at most {:.0f} s left", progress.seconds * (1.0 / share - 1.0)) : "";
  const std::string line = fmt::format("{}: {} evaluations, {:.0f}/s, {:.1f} s{}, {}", what_, progress.evaluations, rate,
                                       progress.seconds, left, best_so_far(meter));
  if (terminal_) {
    constexpr int kWidth = 20;
    const int filled = static_cast<int>(std::lround(share * kWidth));
    std::string bar = fmt::format("[{:=<{}}{: <{}}] {}", "", filled, "", kWidth - filled, line);
    bar.resize(std::min(bar.size(), terminal_width() - 1));  // what runs on into a second line could not be taken off
    fmt::print(stderr, "\r\033[K{}", bar);
    shown_ = true;
  } else {
    fmt::print(stderr, "{}\n", line);
  }
  std::fflush(stderr);
}

void ProgressDisplay::finish() {
  if (shown_) fmt::print(stderr, "\r\033[K");
  shown_ = false;
}

}  // namespace modsearch::app
