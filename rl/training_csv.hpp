#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <modsearch/rl/training.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace modsearch {

/// The log of a training: a table with one row per evaluation that grows as the training goes on. Every row is on disk
/// when append() returns. Columns: see training_csv_columns().
class TrainingCsv {
 public:
  /// Begins a log, in place of whatever `file` is. `rows`: what a training that goes on from a checkpoint remembers; it
  /// is that which counts, whatever has become of the log meanwhile. Throws FileError if it cannot be written.
  explicit TrainingCsv(const std::filesystem::path& file, const std::vector<EvaluationPoint>& rows = {});

  /// Adds a row. Throws FileError if it cannot be written.
  void append(const EvaluationPoint& point);

 private:
  [[noreturn]] void fail() const;

  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Closer> file_;
};

/// First line of a log: the names of its columns, with units.
[[nodiscard]] std::string training_csv_columns();
/// Reads a log; a last row that was cut off is left out.
/// Throws FileError (file, line, value) for anything that TrainingCsv does not write.
[[nodiscard]] std::vector<EvaluationPoint> load_training_csv(const std::filesystem::path& file);

}  // namespace modsearch
