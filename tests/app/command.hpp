#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace modsearch::testing {

/// What a run of the program gave.
struct Outcome {
  int status = -1;
  std::string out;
  std::string err;
};

inline std::string read_text(const std::filesystem::path& file) {
  std::ifstream stream{file};
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// A folder of its own for each test, gone afterwards.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "modsearch-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// A child process whose outputs go to files.
class Child {
 public:
  Child(const std::vector<std::string>& arguments, const std::filesystem::path& folder)
      : out_{folder / "stdout.txt"}, err_{folder / "stderr.txt"} {
    std::vector<char*> argv;
    std::vector<std::string> words{MODSEARCH_COMMAND};
    words.insert(words.end(), arguments.begin(), arguments.end());
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      const auto redirect = [](const std::filesystem::path& file, int to) {
        const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
        dup2(descriptor, to);
      };
      redirect(out_, STDOUT_FILENO);
      redirect(err_, STDERR_FILENO);
      execv(argv[0], argv.data());
      _exit(127);
    }
  }
  void interrupt() const { kill(pid_, SIGINT); }
  [[nodiscard]] Outcome wait() const {
    int status = 0;
    waitpid(pid_, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), read_text(out_), read_text(err_)};
  }

 private:
  std::filesystem::path out_;
  std::filesystem::path err_;
  pid_t pid_ = -1;
};

inline Outcome modsearch(const std::vector<std::string>& arguments, const TemporaryFolder& folder) {
  return Child{arguments, folder.path()}.wait();
}

}  // namespace modsearch::testing
