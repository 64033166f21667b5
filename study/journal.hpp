#pragma once

#include <chrono>
#include <filesystem>
#include <modsearch/study/records.hpp>
#include <string>

namespace modsearch {

/// The append-only record of a study: one JSON object per line, the truth from which everything else is made.
///
/// What belongs to one moment (a finished cell with its improvements) is one write(), so that a program that is killed
/// at any byte leaves whole lines and at most one torn one at the end. Nothing is ever rewritten. Data is forced on to
/// the disk once a second and at the end: a machine that loses its power loses at most the last second's cells. Whoever
/// writes one holds the OutputLock of its folder.
class Journal {
 public:
  /// A new journal. Throws FileError if `file` exists or cannot be written.
  static Journal begin(const std::filesystem::path& file, const StudyFacts& study);
  /// Goes on with a journal; a torn last line is cut off first. Throws FileError if it cannot be written.
  static Journal resume(const std::filesystem::path& file);

  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&&) = delete;
  ~Journal();

  void start(const CellRecord& cell);
  /// A cell that is done, with its improvements, or failed. Throws std::invalid_argument for one that is only started.
  void finish(const CellRecord& cell);

 private:
  Journal(const std::filesystem::path& file, int flags);
  void append(const std::string& lines);
  void force();
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::chrono::steady_clock::time_point forced_;
};

}  // namespace modsearch
