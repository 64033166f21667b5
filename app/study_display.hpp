#pragma once

#include <chrono>
#include <modsearch/study/run_study.hpp>

namespace modsearch::app {

/// Shows on stderr how a comparison goes: a bar with the time left on a terminal, a plain line every few seconds
/// otherwise, nothing when quiet.
class StudyDisplay {
 public:
  explicit StudyDisplay(bool quiet);
  ~StudyDisplay();
  StudyDisplay(const StudyDisplay&) = delete;
  StudyDisplay& operator=(const StudyDisplay&) = delete;

  void update(const StudyProgress& progress);
  /// Takes the bar off the screen.
  void finish();

 private:
  bool quiet_;
  bool terminal_;
  bool shown_ = false;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace modsearch::app
