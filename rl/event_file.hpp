#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>

namespace modsearch {

/// A log of scalars that TensorBoard shows: an event file, written as it grows. Records are framed as in TensorFlow's
/// TFRecord (uint64 length, masked CRC-32C of it, the record, masked CRC-32C of the record; little-endian), and each is
/// a protocol buffer `Event` (event.proto and summary.proto of TensorFlow) of which only times, steps, the version and
/// scalars are used. What is written is on disk when a call returns: a training that is killed loses nothing.
class EventFile {
 public:
  /// Opens "events.out.tfevents.<seconds>.modsearch" in `directory`, which is made where it is missing; TensorBoard
  /// takes all event files of a directory for one run, and all directories below its --logdir for runs. A file that is
  /// there already gets no more records, because behind a torn one nobody would read them: the new one is then named
  /// "..modsearch.1".
  /// `wall_time`: now, in seconds since 1970. Throws FileError if the file cannot be opened or written.
  EventFile(const std::filesystem::path& directory, double wall_time);

  /// The value `value` of the curve `tag` at `step`. A slash in the tag makes groups: "evaluation/return".
  /// `wall_time`: now [s since 1970]. Throws FileError if it cannot be written.
  void scalar(std::string_view tag, std::int64_t step, double value, double wall_time);
  /// Whatever earlier files of the directory hold from `step` on is void: a training goes on from a checkpoint.
  void restart(std::int64_t step, double wall_time);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  void open_new(const std::filesystem::path& plain);
  void write(std::string_view event);
  [[noreturn]] void fail() const;

  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Closer> file_;
};

}  // namespace modsearch
