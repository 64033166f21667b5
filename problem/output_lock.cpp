#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <map>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/output_lock.hpp>
#include <mutex>
#include <optional>
#include <utility>

namespace modsearch {
namespace {

// POSIX gives a lock to a process, not to a part of it: what this one holds, it has to know itself. To open and close
// the file of a lock that is held would end it, so that this is asked first.
class HeldHere {
 public:
  /// What the holder says of itself, where there is one already.
  std::optional<std::string> add(const std::filesystem::path& lock, const std::string& words) {
    const std::scoped_lock guard{mutex_};
    const auto [held, is_new] = held_.emplace(lock, words);
    return is_new ? std::nullopt : std::optional{held->second};
  }
  void remove(const std::filesystem::path& lock) {
    const std::scoped_lock guard{mutex_};
    held_.erase(lock);
  }

 private:
  std::mutex mutex_;
  std::map<std::filesystem::path, std::string> held_;  // what each holder says of itself
};

HeldHere& held_here() {
  static HeldHere held;
  return held;
}

// One line of at most 200 printable characters.
std::string one_line(std::string text) {
  constexpr std::size_t kLongest = 200;
  if (text.size() > kLongest) text = text.substr(0, kLongest - 3) + "...";
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, ' ');
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

// As it was typed but for quotes: words are separated by zeros.
std::string own_command() {
  std::ifstream stream{"/proc/self/cmdline", std::ios::binary};
  return one_line(std::string{std::istreambuf_iterator<char>{stream}, {}});
}

std::string own_host() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? one_line(name.data()) : "a host without a name";
}

std::string own_words() {
  return fmt::format("process {} on {} since {:%Y-%m-%d %H:%M:%S} UTC: {}", ::getpid(), own_host(),
                     fmt::gmtime(std::time(nullptr)), own_command());
}

// What the holder says of itself; it may not have come to that yet.
std::string words_of_holder(int descriptor) {
  std::array<char, 1024> text{};
  const ::ssize_t n = ::pread(descriptor, text.data(), text.size(), 0);
  if (n <= 0) return "another process";
  const std::string line{text.data(), static_cast<std::size_t>(n)};
  return one_line(line.substr(0, line.find('\n')));
}

struct ::flock whole_file() {
  struct ::flock whole {};
  whole.l_type = F_WRLCK;
  whole.l_whence = SEEK_SET;
  return whole;
}

[[noreturn]] void fail(const std::filesystem::path& output, int reason) {
  throw FileError(
      fmt::format("{}: cannot be locked against other writers: {}", output.string(), std::strerror(reason)));
}

// The same name for one place, whatever links lead there.
std::filesystem::path real(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::absolute(path, error);
  std::filesystem::path found = std::filesystem::weakly_canonical(absolute, error);
  return error ? absolute : found;
}

}  // namespace

OutputLock OutputLock::of_folder(const std::filesystem::path& folder) {
  return {folder, real(folder) / ".modsearch.lock"};
}

OutputLock OutputLock::of_file(const std::filesystem::path& file) {
  std::error_code none;
  if (std::filesystem::exists(file, none) && !std::filesystem::is_regular_file(file, none)) return {};
  std::filesystem::path lock = real(file);
  lock += ".lock";
  return {file, std::move(lock)};
}

OutputLock::OutputLock(const std::filesystem::path& output, std::filesystem::path lock) {
  const std::string words = own_words();
  if (const std::optional<std::string> holder = held_here().add(lock, words)) {
    throw FileError(fmt::format("{}: is being written by {}", output.string(), *holder));
  }
  path_ = std::move(lock);
  holder_ = ::getpid();
  try {
    // A holder that has just ended takes the file away: then what was locked is no longer what others will find.
    do {
      if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
      take(output);
    } while (!is_in_place());
  } catch (...) {
    held_here().remove(path_);
    throw;
  }
  sign(words);
}

void OutputLock::take(const std::filesystem::path& output) {
  descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail(output, errno);
  const struct ::flock whole = whole_file();
  if (::fcntl(descriptor_, F_SETLK, &whole) == 0) return;
  const int reason = errno;
  const std::string holder = words_of_holder(descriptor_);
  ::close(std::exchange(descriptor_, -1));
  if (reason != EACCES && reason != EAGAIN) fail(output, reason);
  throw FileError(fmt::format("{}: is being written by {}", output.string(), holder));
}

void OutputLock::sign(const std::string& words) const {
  // On a full disk the lock holds without the words.
  const std::string line = words + '\n';
  if (::ftruncate(descriptor_, 0) != 0) return;
  static_cast<void>(::pwrite(descriptor_, line.data(), line.size(), 0) == 0);
}

bool OutputLock::is_in_place() const {
  struct ::stat opened {};
  struct ::stat named {};
  return ::fstat(descriptor_, &opened) == 0 && ::stat(path_.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

OutputLock::OutputLock(OutputLock&& other) noexcept
    : path_{std::move(other.path_)}, descriptor_{std::exchange(other.descriptor_, -1)}, holder_{other.holder_} {}

OutputLock::~OutputLock() {
  if (descriptor_ < 0) return;
  const bool holds = holder_ == ::getpid();
  if (holds && is_in_place()) ::unlink(path_.c_str());
  ::close(descriptor_);
  if (holds) held_here().remove(path_);
}

}  // namespace modsearch
