#include "app/progress_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "app/standard_streams.hpp"
#include "app/terminal.hpp"

namespace modsearch::app {

ProgressLine::ProgressLine(bool quiet) : quiet_{quiet}, terminal_{isatty(STDERR_FILENO) == 1}, last_{Clock::now()} {}

ProgressLine::~ProgressLine() { finish(); }

bool ProgressLine::due() {
  if (quiet_) return false;
  const auto now = Clock::now();
  if (now - last_ < (terminal_ ? std::chrono::milliseconds{100} : std::chrono::milliseconds{5000})) return false;
  last_ = now;
  return true;
}

void ProgressLine::show(double share, const std::string& text) {
  if (quiet_) return;
  if (terminal_) {
    constexpr int kWidth = 20;
    const int filled = static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * kWidth));
    std::string bar = fmt::format("[{:=<{}}{: <{}}] {}", "", filled, "", kWidth - filled, text);
    bar.resize(std::min(bar.size(), terminal_width() - 1));  // what runs on into a second line could not be taken off
    tell("\r\033[K" + bar);
    shown_ = true;
  } else {
    tell(text + '\n');
  }
}

void ProgressLine::say(const std::string& text) {
  if (quiet_) return;
  finish();
  tell(text + '\n');
}

void ProgressLine::finish() {
  if (shown_) tell("\r\033[K");
  shown_ = false;
}

}  // namespace modsearch::app
