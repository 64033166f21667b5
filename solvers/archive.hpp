#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace modsearch {

/// Named values in one binary file: what checkpoints are made of.
///
/// The file, all numbers little-endian:
///   "MSARCHIV", uint32 version = 1,
///   entries: uint32 length of the name, uint32 kind (Kind), uint64 bytes of the values, the name, the values;
///   uint32 CRC-32C of all that precedes it.
/// A list of texts holds per text: uint64 length, the text.
///
/// The archive is kept in memory as the file it becomes, so that saving copies nothing and putting n bytes costs O(n).
class Archive {
 public:
  enum class Kind : std::uint32_t { kBytes = 0, kTexts, kInt64, kUint64, kFloat, kDouble };

  Archive();
  /// Reads a file. Throws FileError if it cannot be read, is no archive, was written by a later version, or was
  /// truncated or altered.
  [[nodiscard]] static Archive load(const std::filesystem::path& file);
  /// Writes the file, whole or not at all. Throws FileError if that fails.
  void save(const std::filesystem::path& file) const;

  // Putting throws std::invalid_argument if the name is empty or already there.
  void put(const std::string& name, std::span<const std::byte> values);
  void put(const std::string& name, std::span<const std::int64_t> values);
  void put(const std::string& name, std::span<const std::uint64_t> values);
  void put(const std::string& name, std::span<const float> values);
  void put(const std::string& name, std::span<const double> values);
  void put(const std::string& name, std::span<const std::string> texts);
  void put_integer(const std::string& name, std::int64_t value) { put(name, std::span{&value, 1}); }
  void put_number(const std::string& name, double value) { put(name, std::span{&value, 1}); }
  void put_text(const std::string& name, const std::string& text) { put(name, std::span{&text, 1}); }

  // Getting throws FileError, naming file and entry, if there is no such entry or it holds something else.
  /// A view that lasts until the archive is changed or gone.
  [[nodiscard]] std::span<const std::byte> bytes(const std::string& name) const;
  [[nodiscard]] std::vector<std::int64_t> integers(const std::string& name) const;
  [[nodiscard]] std::vector<std::uint64_t> unsigned_integers(const std::string& name) const;
  [[nodiscard]] std::vector<float> floats(const std::string& name) const;
  [[nodiscard]] std::vector<double> numbers(const std::string& name) const;
  [[nodiscard]] std::vector<std::string> texts(const std::string& name) const;
  /// Entries of exactly one value.
  [[nodiscard]] std::int64_t integer(const std::string& name) const;
  [[nodiscard]] double number(const std::string& name) const;
  [[nodiscard]] std::string text(const std::string& name) const;

  [[nodiscard]] bool has(const std::string& name) const { return entries_.contains(name); }
  /// Sorted.
  [[nodiscard]] std::vector<std::string> names() const;
  /// Throws FileError: "FILE: entry 'NAME': WHAT"; for readers of what an archive holds.
  [[noreturn]] void fail(const std::string& name, const std::string& what) const;

 private:
  struct Entry {
    Kind kind = Kind::kBytes;
    std::size_t begin = 0;  // in image_
    std::size_t size = 0;   // [bytes]
  };

  void put(const std::string& name, Kind kind, std::span<const std::byte> values);
  [[nodiscard]] std::span<const std::byte> values_of(const std::string& name, Kind kind) const;
  template <typename T>
  [[nodiscard]] std::vector<T> numbers_of(const std::string& name, Kind kind) const;
  void read_entries();

  std::string label_ = "archive";  // the file it was read from, for messages
  std::string image_;              // the bytes of the file, its checksum included
  std::map<std::string, Entry> entries_;
};

}  // namespace modsearch
