#pragma once

#include <modsearch/solvers/meter.hpp>
#include <string>

#include "app/progress_line.hpp"

namespace modsearch::app {

/// One line about how a search goes: the best so far, what the solver is at, how fast it is, the time left, and why
/// most designs failed. What matters most comes first, because a narrow terminal cuts off the end.
[[nodiscard]] std::string progress_text(const std::string& what, const Meter& meter);

/// Shows on stderr how a search goes.
class ProgressDisplay {
 public:
  /// `library`: of the designs, where the first achieved one is to be told at once, on a line that stays; else null. It
  /// must outlive the display.
  ProgressDisplay(std::string what, bool quiet, const ModuleLibrary* library = nullptr);

  /// To be given to a Meter as its observer; looks at the clock only every few calls, and when the stage changes.
  void update(const Meter& meter);
  /// Takes the bar off the screen.
  void finish() { line_.finish(); }

 private:
  void tell_first_achieved(const Meter& meter);

  std::string what_;
  ProgressLine line_;
  const ModuleLibrary* library_;  // null: nothing to be told any more
  std::string stage_;
  int calls_ = 0;
};

}  // namespace modsearch::app
