#pragma once

#include <modsearch/study/run_study.hpp>

#include "app/progress_line.hpp"

namespace modsearch::app {

/// Shows on stderr how a comparison goes, with the time left.
class StudyDisplay {
 public:
  explicit StudyDisplay(bool quiet) : line_{quiet} {}

  void update(const StudyProgress& progress);
  /// Takes the bar off the screen.
  void finish() { line_.finish(); }

 private:
  ProgressLine line_;
};

}  // namespace modsearch::app
