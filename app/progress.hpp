#pragma once

#include <modsearch/solvers/meter.hpp>
#include <string>

#include "app/progress_line.hpp"

namespace modsearch::app {

/// Shows on stderr how a search goes, with rate and time left.
class ProgressDisplay {
 public:
  ProgressDisplay(std::string what, bool quiet);

  /// To be given to a Meter as its observer; looks at the clock only every few calls.
  void update(const Meter& meter);
  /// Takes the bar off the screen.
  void finish() { line_.finish(); }

 private:
  std::string what_;
  ProgressLine line_;
  int calls_ = 0;
};

}  // namespace modsearch::app
