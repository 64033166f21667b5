#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/json_internal.hpp>
#include <modsearch/solvers/archive.hpp>
#include <modsearch/solvers/crc32c.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

static_assert(std::endian::native == std::endian::little, "archives are written as memory holds them: little-endian");

constexpr std::string_view kMagic = "MSARCHIV";
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kHeaderSize = kMagic.size() + sizeof kVersion;
constexpr std::size_t kChecksumSize = sizeof(std::uint32_t);
constexpr std::size_t kEntryHeaderSize = 2 * sizeof(std::uint32_t) + sizeof(std::uint64_t);
constexpr std::uintmax_t kLargestFile = std::uintmax_t{64} << 30U;  // what a workstation's memory holds

std::span<const std::byte> as_bytes(std::string_view text) { return std::as_bytes(std::span{text}); }

template <typename T>
void append(std::string& image, const T& number) {
  image.append(reinterpret_cast<const char*>(&number), sizeof number);
}

template <typename T>
T number_at(std::span<const std::byte> bytes, std::size_t position) {
  T number;
  std::memcpy(&number, bytes.data() + position, sizeof number);
  return number;
}

std::string_view meaning(Archive::Kind kind) {
  switch (kind) {
    case Archive::Kind::kBytes:
      return "bytes";
    case Archive::Kind::kTexts:
      return "texts";
    case Archive::Kind::kInt64:
      return "integers";
    case Archive::Kind::kUint64:
      return "unsigned integers";
    case Archive::Kind::kFloat:
      return "single-precision numbers";
    case Archive::Kind::kDouble:
      return "double-precision numbers";
  }
  throw std::invalid_argument("archive: no such kind of values");
}

/// Bytes of one value; 1 where values differ in length.
std::size_t size_of_one(Archive::Kind kind) {
  switch (kind) {
    case Archive::Kind::kBytes:
    case Archive::Kind::kTexts:
      return 1;
    case Archive::Kind::kFloat:
      return 4;
    case Archive::Kind::kInt64:
    case Archive::Kind::kUint64:
    case Archive::Kind::kDouble:
      return 8;
  }
  throw std::invalid_argument("archive: no such kind of values");
}

}  // namespace

Archive::Archive() {
  image_ = kMagic;
  append(image_, kVersion);
  append(image_, crc32c(as_bytes(image_)));
}

void Archive::put(const std::string& name, Kind kind, std::span<const std::byte> values) {
  if (name.empty()) throw std::invalid_argument("archive: an entry without a name");
  if (has(name)) throw std::invalid_argument(fmt::format("archive: entry '{}' is put twice", name));
  const auto before = number_at<std::uint32_t>(as_bytes(image_), image_.size() - kChecksumSize);
  const std::size_t begin = image_.size() - kChecksumSize;
  image_.resize(begin);
  append(image_, static_cast<std::uint32_t>(name.size()));
  append(image_, kind);
  append(image_, std::uint64_t{values.size()});
  image_ += name;
  entries_[name] = {.kind = kind, .begin = image_.size(), .size = values.size()};
  image_.append(reinterpret_cast<const char*>(values.data()), values.size());
  append(image_, crc32c(as_bytes(image_).subspan(begin), before));
}

void Archive::put(const std::string& name, std::span<const std::byte> values) { put(name, Kind::kBytes, values); }

void Archive::put(const std::string& name, std::span<const std::int64_t> values) {
  put(name, Kind::kInt64, std::as_bytes(values));
}

void Archive::put(const std::string& name, std::span<const std::uint64_t> values) {
  put(name, Kind::kUint64, std::as_bytes(values));
}

void Archive::put(const std::string& name, std::span<const float> values) {
  put(name, Kind::kFloat, std::as_bytes(values));
}

void Archive::put(const std::string& name, std::span<const double> values) {
  put(name, Kind::kDouble, std::as_bytes(values));
}

void Archive::put(const std::string& name, std::span<const std::string> texts) {
  std::string list;
  for (const std::string& text : texts) {
    append(list, std::uint64_t{text.size()});
    list += text;
  }
  put(name, Kind::kTexts, as_bytes(list));
}

void Archive::save(const std::filesystem::path& file) const { write_file(file, image_); }

Archive Archive::load(const std::filesystem::path& file) {
  Archive archive;
  archive.label_ = file.string();
  archive.image_ = detail::read_text(file, archive.label_, kLargestFile);
  archive.read_entries();
  return archive;
}

void Archive::read_entries() {
  const auto refuse = [&](const std::string& what) { throw FileError(fmt::format("{}: {}", label_, what)); };
  const std::span<const std::byte> image = as_bytes(image_);
  if (!image_.starts_with(kMagic)) {
    refuse(fmt::format("is not an archive of modsearch (limit: begins with \"{}\")", kMagic));
  }
  if (image.size() < kHeaderSize + kChecksumSize) {
    refuse(fmt::format("was cut off after {} bytes (limit: at least {})", image.size(), kHeaderSize + kChecksumSize));
  }
  if (const auto version = number_at<std::uint32_t>(image, kMagic.size()); version != kVersion) {
    refuse(fmt::format("has version {} of the format (limit {})", version, kVersion));
  }
  const std::size_t end = image.size() - kChecksumSize;
  const auto claimed = number_at<std::uint32_t>(image, end);
  if (const std::uint32_t found = crc32c(image.first(end)); found != claimed) {
    refuse(fmt::format("was truncated or altered: its {} bytes have checksum {:#010x}, not {:#010x}", image.size(),
                       found, claimed));
  }
  // The checksum tells accidents; what was forged must not crash either.
  for (std::size_t position = kHeaderSize; position < end;) {
    const auto malformed = [&] { refuse(fmt::format("has a malformed entry at byte {}", position)); };
    if (end - position < kEntryHeaderSize) malformed();
    const auto name_size = number_at<std::uint32_t>(image, position);
    const auto kind = number_at<std::uint32_t>(image, position + 4);
    const auto size = number_at<std::uint64_t>(image, position + 8);
    const std::size_t left = end - position - kEntryHeaderSize;
    if (name_size == 0 || name_size > left || size > left - name_size) malformed();
    if (kind > static_cast<std::uint32_t>(Kind::kDouble) || size % size_of_one(Kind{kind}) != 0) malformed();
    const std::size_t begin = position + kEntryHeaderSize + name_size;
    const std::string name = image_.substr(position + kEntryHeaderSize, name_size);
    if (!entries_.emplace(name, Entry{Kind{kind}, begin, static_cast<std::size_t>(size)}).second) malformed();
    position = begin + static_cast<std::size_t>(size);
  }
}

void Archive::fail(const std::string& name, const std::string& what) const {
  throw FileError(fmt::format("{}: entry '{}': {}", label_, name, what));
}

std::span<const std::byte> Archive::values_of(const std::string& name, Kind kind) const {
  const auto found = entries_.find(name);
  if (found == entries_.end()) fail(name, "is missing");
  const Entry& entry = found->second;
  if (entry.kind != kind) fail(name, fmt::format("holds {}, not {}", meaning(entry.kind), meaning(kind)));
  return as_bytes(image_).subspan(entry.begin, entry.size);
}

template <typename T>
std::vector<T> Archive::numbers_of(const std::string& name, Kind kind) const {
  const std::span<const std::byte> bytes = values_of(name, kind);
  std::vector<T> result(bytes.size() / sizeof(T));
  if (!result.empty()) std::memcpy(result.data(), bytes.data(), bytes.size());
  return result;
}

std::span<const std::byte> Archive::bytes(const std::string& name) const { return values_of(name, Kind::kBytes); }

std::vector<std::int64_t> Archive::integers(const std::string& name) const {
  return numbers_of<std::int64_t>(name, Kind::kInt64);
}

std::vector<std::uint64_t> Archive::unsigned_integers(const std::string& name) const {
  return numbers_of<std::uint64_t>(name, Kind::kUint64);
}

std::vector<float> Archive::floats(const std::string& name) const { return numbers_of<float>(name, Kind::kFloat); }

std::vector<double> Archive::numbers(const std::string& name) const { return numbers_of<double>(name, Kind::kDouble); }

std::vector<std::string> Archive::texts(const std::string& name) const {
  std::span<const std::byte> rest = values_of(name, Kind::kTexts);
  std::vector<std::string> result;
  while (!rest.empty()) {
    if (rest.size() < sizeof(std::uint64_t)) fail(name, "ends within a text");
    const auto size = number_at<std::uint64_t>(rest, 0);
    rest = rest.subspan(sizeof size);
    if (size > rest.size()) fail(name, "ends within a text");
    result.emplace_back(reinterpret_cast<const char*>(rest.data()), static_cast<std::size_t>(size));
    rest = rest.subspan(static_cast<std::size_t>(size));
  }
  return result;
}

namespace {

template <typename T>
T the_one(const Archive& archive, const std::string& name, std::vector<T> values) {
  if (values.size() != 1) archive.fail(name, fmt::format("holds {} values (limit: 1)", values.size()));
  return std::move(values.front());
}

}  // namespace

std::int64_t Archive::integer(const std::string& name) const { return the_one(*this, name, integers(name)); }

double Archive::number(const std::string& name) const { return the_one(*this, name, numbers(name)); }

std::string Archive::text(const std::string& name) const { return the_one(*this, name, texts(name)); }

std::vector<std::string> Archive::names() const {
  std::vector<std::string> result;
  for (const auto& [name, entry] : entries_) result.push_back(name);
  return result;
}

}  // namespace modsearch
