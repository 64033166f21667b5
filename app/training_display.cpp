#include "app/training_display.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace modsearch::app {

TrainingDisplay::TrainingDisplay(std::string what, bool quiet)
    : what_{std::move(what)},
      quiet_{quiet},
      terminal_{isatty(STDERR_FILENO) == 1},
      start_{std::chrono::steady_clock::now()},
      last_{start_} {}

TrainingDisplay::~TrainingDisplay() { finish(); }

void TrainingDisplay::update(const Trainer& trainer) {
  if (quiet_) return;
  if (first_episode_ < 0) first_episode_ = trainer.episode() - trainer.options().evaluate_every;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < (terminal_ ? std::chrono::milliseconds{100} : std::chrono::milliseconds{5000})) return;
  last_ = now;

  const EvaluationPoint& point = trainer.history().back();
  const std::int64_t episodes = trainer.options().episodes;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double rate = static_cast<double>(point.episode - first_episode_) / seconds;
  const std::string line = fmt::format(
      "{}: {} of {} episodes, {:.0f}/s, at most {:.0f} s left; greedy return {:.3f}, {:.0f} % in one step, epsilon "
      "{:.2f}",
      what_, point.episode, episodes, rate, static_cast<double>(episodes - point.episode) / rate,
      point.evaluation.mean_return, 100.0 * point.evaluation.one_step_share, point.epsilon);
  if (terminal_) {
    constexpr int kWidth = 20;
    const double share = static_cast<double>(point.episode) / static_cast<double>(episodes);
    const int filled = static_cast<int>(std::lround(share * kWidth));
    fmt::print(stderr, "\r\033[K[{:=<{}}{: <{}}] {}", "", filled, "", kWidth - filled, line);
    shown_ = true;
  } else {
    fmt::print(stderr, "{}\n", line);
  }
  std::fflush(stderr);
}

void TrainingDisplay::finish() {
  if (shown_) fmt::print(stderr, "\r\033[K");
  shown_ = false;
}

}  // namespace modsearch::app
