#pragma once

#include <chrono>
#include <modsearch/solvers/meter.hpp>
#include <string>

namespace modsearch::app {

/// Shows on stderr how a search goes: a bar with rate and time left on a terminal, a plain line every few seconds
/// otherwise, nothing when quiet.
class ProgressDisplay {
 public:
  ProgressDisplay(std::string what, bool quiet);
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  /// To be given to a Meter as its observer; looks at the clock only every few calls.
  void update(const Meter& meter);
  /// Takes the bar off the screen.
  void finish();

 private:
  void show(const Meter& meter);

  std::string what_;
  bool quiet_;
  bool terminal_;
  bool shown_ = false;
  int calls_ = 0;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace modsearch::app
