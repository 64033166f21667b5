#pragma once

#include <chrono>
#include <modsearch/rl/training.hpp>
#include <string>

namespace modsearch::app {

/// Shows on stderr how a training goes: one line that renews itself on a terminal, a plain line every few seconds
/// otherwise, nothing when quiet.
class TrainingDisplay {
 public:
  TrainingDisplay(std::string what, bool quiet);
  ~TrainingDisplay();
  TrainingDisplay(const TrainingDisplay&) = delete;
  TrainingDisplay& operator=(const TrainingDisplay&) = delete;

  /// To be called after every evaluation.
  void update(const Trainer& trainer);
  /// Takes the line off the screen.
  void finish();

 private:
  std::string what_;
  bool quiet_;
  bool terminal_;
  bool shown_ = false;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_;
  std::int64_t first_episode_ = -1;  // of this run: a resumed training does not begin at 0
};

}  // namespace modsearch::app
