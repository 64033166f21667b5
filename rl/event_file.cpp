#include <fmt/format.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <modsearch/problem/files.hpp>
#include <modsearch/rl/event_file.hpp>
#include <modsearch/solvers/crc32c.hpp>
#include <span>
#include <string>

namespace modsearch {
namespace {

static_assert(std::endian::native == std::endian::little, "event files are little-endian");

/// A message in protocol buffers' wire format: every field is its number and the way its bytes are to be read, then
/// those.
class Message {
 public:
  Message& integer(std::uint32_t field, std::int64_t value) {
    key(field, 0);
    varint(static_cast<std::uint64_t>(value));
    return *this;
  }
  Message& number(std::uint32_t field, double value) {
    key(field, 1);
    return raw(value);
  }
  Message& number(std::uint32_t field, float value) {
    key(field, 5);
    return raw(value);
  }
  Message& text(std::uint32_t field, std::string_view value) {
    key(field, 2);
    varint(value.size());
    bytes_ += value;
    return *this;
  }
  Message& message(std::uint32_t field, const Message& value) { return text(field, value.bytes_); }

  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  void key(std::uint32_t field, std::uint32_t wire_type) { varint(field << 3 | wire_type); }
  /// Seven bits a byte, the lowest first; the eighth says that more follow.
  void varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_ += static_cast<char>((value & 0x7F) | 0x80);
    bytes_ += static_cast<char>(value);
  }
  template <typename T>
  Message& raw(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }

  std::string bytes_;
};

// Field numbers of event.proto and summary.proto.
constexpr std::uint32_t kEventWallTime = 1;
constexpr std::uint32_t kEventStep = 2;
constexpr std::uint32_t kEventFileVersion = 3;
constexpr std::uint32_t kEventSummary = 5;
constexpr std::uint32_t kEventSessionLog = 7;
constexpr std::uint32_t kSummaryValue = 1;
constexpr std::uint32_t kValueTag = 1;
constexpr std::uint32_t kValueSimpleValue = 2;
constexpr std::uint32_t kSessionLogStatus = 1;
constexpr std::int64_t kSessionStart = 1;

/// A checksum as TFRecord keeps it: turned and shifted, because the CRC of something that holds its own CRC is weak.
std::uint32_t masked_checksum(std::string_view bytes) {
  constexpr std::uint32_t kShift = 0xA282EAD8;
  return std::rotr(crc32c(std::as_bytes(std::span{bytes})), 15) + kShift;
}

template <typename T>
void append(std::string& bytes, T number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

}  // namespace

EventFile::EventFile(const std::filesystem::path& directory, double wall_time) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) throw FileError(fmt::format("{}: cannot be made: {}", directory.string(), error.message()));
  open_new(directory /
           fmt::format("events.out.tfevents.{:010}.modsearch", static_cast<std::int64_t>(std::floor(wall_time))));
  write(Message{}.number(kEventWallTime, wall_time).text(kEventFileVersion, "brain.Event:2").bytes());
}

void EventFile::open_new(const std::filesystem::path& plain) {
  path_ = plain;
  for (int number = 1; file_ == nullptr; ++number) {
    file_.reset(std::fopen(path_.c_str(), "wbx"));
    if (file_ == nullptr && errno != EEXIST) fail();
    if (file_ == nullptr) path_ = fmt::format("{}.{}", plain.string(), number);
  }
}

void EventFile::scalar(std::string_view tag, std::int64_t step, double value, double wall_time) {
  const Message summary = Message{}.message(
      kSummaryValue, Message{}.text(kValueTag, tag).number(kValueSimpleValue, static_cast<float>(value)));
  write(Message{}.number(kEventWallTime, wall_time).integer(kEventStep, step).message(kEventSummary, summary).bytes());
}

void EventFile::restart(std::int64_t step, double wall_time) {
  const Message session = Message{}.integer(kSessionLogStatus, kSessionStart);
  write(
      Message{}.number(kEventWallTime, wall_time).integer(kEventStep, step).message(kEventSessionLog, session).bytes());
}

void EventFile::write(std::string_view event) {
  std::string record;
  append(record, std::uint64_t{event.size()});
  append(record, masked_checksum(record));
  record += event;
  append(record, masked_checksum(event));
  if (std::fwrite(record.data(), 1, record.size(), file_.get()) != record.size() || std::fflush(file_.get()) != 0) {
    fail();
  }
}

void EventFile::fail() const {
  throw FileError(fmt::format("{}: cannot be written: {}", path_.string(), std::strerror(errno)));
}

}  // namespace modsearch
