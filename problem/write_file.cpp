#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <modsearch/problem/files.hpp>

namespace modsearch {
namespace {

/// Closes and removes what is left of an attempt to write.
class Draft {
 public:
  explicit Draft(const std::filesystem::path& target) : target_{target} {
    // Process and count keep writers apart, threads included. What is there already was left by one that was killed: in
    // a container the next process may well have its number.
    static std::atomic<unsigned> count{0};
    do {
      path_ = fmt::format("{}.{}-{}.part", target.string(), ::getpid(), count++);
      descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (descriptor_ < 0 && errno == EEXIST);
    if (descriptor_ < 0) fail();
  }
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;
  ~Draft() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!kept_) ::unlink(path_.c_str());
  }

  void write(std::string_view text) {
    while (!text.empty()) {
      const ::ssize_t written = ::write(descriptor_, text.data(), text.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail();
      text.remove_prefix(static_cast<std::size_t>(written));
    }
    if (::fsync(descriptor_) != 0) fail();
    if (::close(std::exchange(descriptor_, -1)) != 0) fail();
  }

  /// Puts the draft in the place of the target.
  void keep() {
    if (::rename(path_.c_str(), target_.c_str()) != 0) fail();
    kept_ = true;
  }

 private:
  [[noreturn]] void fail() {
    const int reason = errno;
    if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
    ::unlink(path_.c_str());
    throw FileError(fmt::format("{}: cannot be written: {}", target_.string(), std::strerror(reason)));
  }

  std::filesystem::path path_;
  std::filesystem::path target_;
  int descriptor_ = -1;
  bool kept_ = false;
};

std::filesystem::path final_target(const std::filesystem::path& link) {
  std::error_code failed;
  std::filesystem::path target = std::filesystem::weakly_canonical(link, failed);
  return failed ? link : target;
}

void write_through(const std::filesystem::path& file, std::string_view text) {
  std::ofstream stream{file, std::ios::binary | std::ios::app};
  stream << text << std::flush;
  if (!stream) throw FileError(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(errno)));
}

}  // namespace

void write_file(const std::filesystem::path& file, std::string_view text) {
  // A link stands for the file that it names; a device or a pipe takes the text as it comes.
  std::error_code none;
  const std::filesystem::path target = std::filesystem::is_symlink(file, none) ? final_target(file) : file;
  if (std::filesystem::exists(target, none) && !std::filesystem::is_regular_file(target, none) &&
      !std::filesystem::is_directory(target, none)) {
    write_through(target, text);
    return;
  }
  Draft draft{target};
  draft.write(text);
  draft.keep();
}

}  // namespace modsearch
