#pragma once

#include <chrono>
#include <modsearch/rl/training.hpp>
#include <string>

#include "app/progress_line.hpp"

namespace modsearch::app {

/// Shows on stderr how a training goes, with rate and time left.
class TrainingDisplay {
 public:
  TrainingDisplay(std::string what, bool quiet);

  /// To be called after every evaluation.
  void update(const Trainer& trainer);
  /// Takes the line off the screen.
  void finish() { line_.finish(); }

 private:
  std::string what_;
  ProgressLine line_;
  std::chrono::steady_clock::time_point start_;
  std::int64_t first_episode_ = -1;  // of this run: a resumed training does not begin at 0
};

}  // namespace modsearch::app
