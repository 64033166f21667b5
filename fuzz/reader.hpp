#pragma once

// What the fuzzers of the readers share. A fuzzer is one file: it defines LLVMFuzzerTestOneInput by one call of read(),
// and is linked with libFuzzer, or with replay.cpp, which runs it over the files of a corpus.

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace fuzz {

/// A folder of this process, gone with it.
class Folder {
 public:
  Folder() : path_{std::filesystem::temp_directory_path() / ("modsearch_fuzz_" + std::to_string(::getpid()))} {
    std::filesystem::create_directories(path_);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The input as a file `name`: the readers read files, as users have them.
inline std::filesystem::path as_file(std::string_view input, const std::string& name) {
  static const Folder folder;
  std::filesystem::path file = folder.path() / name;
  std::ofstream{file, std::ios::binary | std::ios::trunc}.write(input.data(),
                                                                static_cast<std::streamsize>(input.size()));
  return file;
}

inline std::string_view text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Reads, and lets pass what the reader says that it throws (`Documented`). Anything else ends the program: an
/// exception of another kind, a crash, a finding of a sanitizer, too much time or memory.
template <typename Documented, typename Read>
int read(Read&& reader) {
  try {
    reader();
  } catch (const Documented&) {
  }
  return 0;
}

}  // namespace fuzz
