#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <modsearch/study/journal.hpp>
#include <modsearch/study/journal_json_internal.hpp>
#include <utility>

namespace modsearch {
namespace {

// Bytes up to and including the last line's end.
std::uintmax_t whole_lines(const std::filesystem::path& file) {
  return detail::read_text(file, file.string(), detail::kLargestJournal).rfind('\n') + 1;
}

}  // namespace

Journal Journal::begin(const std::filesystem::path& file, const StudyFacts& study) {
  Journal journal{file, O_CREAT | O_EXCL};
  journal.append(detail::to_line(detail::header_line(study)));
  journal.force();
  return journal;
}

Journal Journal::resume(const std::filesystem::path& file) {
  const std::uintmax_t size = whole_lines(file);
  Journal journal{file, 0};
  if (::ftruncate(journal.descriptor_, static_cast<::off_t>(size)) != 0) journal.fail();
  return journal;
}

Journal::Journal(const std::filesystem::path& file, int flags) : path_{file}, forced_{std::chrono::steady_clock::now()} {
  descriptor_ = ::open(file.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC | flags, 0666);
  if (descriptor_ < 0) fail();
}

Journal::Journal(Journal&& other) noexcept
    : path_{std::move(other.path_)}, descriptor_{std::exchange(other.descriptor_, -1)}, forced_{other.forced_} {}

Journal::~Journal() {
  if (descriptor_ < 0) return;
  ::fsync(descriptor_);
  ::close(descriptor_);
}

void Journal::start(const CellRecord& cell) { append(detail::to_line(detail::start_line(cell))); }

void Journal::finish(const CellRecord& cell) { append(detail::ending_lines(cell)); }

void Journal::append(const std::string& lines) {
  std::string_view rest = lines;
  while (!rest.empty()) {
    const ::ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail();
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  if (std::chrono::steady_clock::now() - forced_ > std::chrono::seconds{1}) force();
}

void Journal::force() {
  if (::fsync(descriptor_) != 0) fail();
  forced_ = std::chrono::steady_clock::now();
}

void Journal::fail() const {
  throw FileError(fmt::format("{}: cannot be written: {}", path_.string(), std::strerror(errno)));
}

}  // namespace modsearch
