#include "app/study_display.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "app/terminal.hpp"

namespace modsearch::app {
namespace {

std::string duration(double seconds) {
  if (seconds < 100.0) return fmt::format("{:.0f} s", seconds);
  if (seconds < 6000.0) return fmt::format("{:.0f} min", seconds / 60.0);
  return fmt::format("{:.1f} h", seconds / 3600.0);
}

}  // namespace

StudyDisplay::StudyDisplay(bool quiet)
    : quiet_{quiet}, terminal_{isatty(STDERR_FILENO) == 1}, last_{std::chrono::steady_clock::now()} {}

StudyDisplay::~StudyDisplay() { finish(); }

void StudyDisplay::update(const StudyProgress& progress) {
  if (quiet_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < (terminal_ ? std::chrono::milliseconds{100} : std::chrono::milliseconds{5000})) return;
  last_ = now;
  std::string line = fmt::format("{} of {} cells", progress.n_ended, progress.n_cells);
  if (progress.n_failed > 0) line += fmt::format(", {} failed", progress.n_failed);
  line += fmt::format(", {}", duration(progress.seconds));
  if (progress.left) line += fmt::format(", about {} left", duration(*progress.left));
  line += fmt::format("; {}", progress.latest);
  if (terminal_) {
    constexpr int kWidth = 20;
    const double share = static_cast<double>(progress.n_ended) / static_cast<double>(progress.n_cells);
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

void StudyDisplay::finish() {
  if (shown_) fmt::print(stderr, "\r\033[K");
  shown_ = false;
}

}  // namespace modsearch::app
