#pragma once

#include <chrono>
#include <string>

namespace modsearch::app {

/// One line on stderr that tells how far something has come: a bar that is drawn anew on a terminal, a plain line every
/// few seconds otherwise, nothing when quiet. Takes the bar off the screen when it ends.
class ProgressLine {
 public:
  using Clock = std::chrono::steady_clock;

  explicit ProgressLine(bool quiet);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  [[nodiscard]] bool quiet() const { return quiet_; }
  /// Whether it is time for another look; if so, the next is a while off.
  [[nodiscard]] bool due();
  /// `share` of the whole, in [0, 1], and what there is to say.
  void show(double share, const std::string& text);
  /// A line that stays, above the bar.
  void say(const std::string& text);
  /// Takes the bar off the screen.
  void finish();

 private:
  bool quiet_;
  bool terminal_;
  bool shown_ = false;
  Clock::time_point last_;
};

}  // namespace modsearch::app
