#pragma once

#include <filesystem>
#include <functional>
#include <modsearch/problem/output_lock.hpp>
#include <modsearch/study/study.hpp>
#include <stdexcept>
#include <stop_token>

namespace modsearch {

/// How far a study has come.
struct StudyProgress {
  std::int64_t n_cells = 0;
  std::int64_t n_ended = 0;   ///< done or failed, those of earlier runs included
  std::int64_t n_failed = 0;  ///< of these
  std::int64_t n_running = 0;
  double seconds = 0.0;  ///< of this run
  /// Estimated seconds to the end, from what cells of the same solver took; nothing before the first has ended.
  std::optional<double> left{};
  std::string latest{};  ///< the cell that started or ended last, in words
};

struct RunOptions {
  /// Gets events.jsonl and policies/; made if it is not there.
  std::filesystem::path folder;
  /// Cells at the same time, each in a process of its own. One: timings are not disturbed by neighbours.
  int jobs = 1;
  /// Goes on with the journal in `folder`: finished cells stay as they are, failed ones are tried again.
  bool resume = false;
  /// So many finished cells, evenly spread, are computed once more at the end and compared: trust, but verify.
  int recheck = 0;
  std::string command{};  ///< for the journal: what was typed
  std::function<void(const StudyProgress&)> progress{};
  std::stop_token stop{};  ///< ends the run; cells that are not finished are lost
  const OutputLock* lock = nullptr;  ///< of the folder, where the caller holds it; null: the run takes it itself
};

/// A cell was computed twice with different results: it is no function of its key, and no comparison with it counts.
class StudyContradiction : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Computes all cells of `study` that the journal does not hold yet and gives back the journal. The results are the
/// same whatever the number of jobs, and however often it was killed and resumed; clock readings and runs that are
/// bounded by seconds are exempt. Cells that throw, crash or are killed are failed, and nothing else. The calling
/// process must have no other threads that compute: cells are computed in copies of it.
///
/// Throws std::invalid_argument for an impossible study or options, FileError for a folder or journal that cannot be
/// used: one that is being written by another program, that is there already (without `resume`), or that belongs to
/// another study, version, compiler or instruction set; StudyContradiction.
StudyRecord run(const Study& study, const RunOptions& options);

}  // namespace modsearch
