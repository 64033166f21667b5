#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace modsearch {

/// The right to write a folder or a file, which one program has at a time: two that write the same place would each
/// take away what the other has found.
///
/// The kernel holds it (a record lock of POSIX on a small file beside the output, `.modsearch.lock` or `FILE.lock`), so
/// that it is gone with its process, however that ends, and works across machines on a shared file system. Processes
/// that are forked do not inherit it. The file says who holds the lock; it is removed at the end, and one that a killed
/// program leaves is in nobody's way.
class OutputLock final {
 public:
  /// Of everything in `folder`, which has to be there. Throws FileError, one sentence with process, host, command and
  /// time of the holder, if another program or another OutputLock of this one has it; FileError if it cannot be locked.
  [[nodiscard]] static OutputLock of_folder(const std::filesystem::path& folder);
  /// Of `file`, whose folder has to be there, whether it is there itself or not. A device or a pipe needs no lock.
  [[nodiscard]] static OutputLock of_file(const std::filesystem::path& file);

  OutputLock(OutputLock&& other) noexcept;
  OutputLock& operator=(OutputLock&& other) = delete;
  ~OutputLock();

 private:
  OutputLock() = default;
  OutputLock(const std::filesystem::path& output, std::filesystem::path lock);
  /// Whether `path_` is still the file that is locked.
  [[nodiscard]] bool is_in_place() const;
  void take(const std::filesystem::path& output);
  void sign(const std::string& words) const;

  std::filesystem::path path_;
  int descriptor_ = -1;
  ::pid_t holder_ = -1;  // a copy in a process that was forked holds nothing
};

}  // namespace modsearch
