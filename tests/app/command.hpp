#pragma once

#include <fcntl.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
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

#include "places.hpp"

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
  /// `out`: where stdout goes instead of into the folder, such as /dev/full.
  Child(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
        const std::filesystem::path& out = {})
      : out_{out.empty() ? folder / "stdout.txt" : out}, err_{folder / "stderr.txt"} {
    std::vector<char*> argv;
    std::vector<std::string> words{test::command()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      signal(SIGINT, SIG_DFL);  // a shell in the background has it ignored
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
  /// Ctrl-C as soon as `file` has a second line, or nothing if the program ends before.
  void interrupt_when_there_is(const std::filesystem::path& file) const {
    const auto ended = [this] {
      siginfo_t info{};
      return waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == pid_;
    };
    const auto lines = [&file] {
      const std::string text = read_text(file);
      return std::count(text.begin(), text.end(), '\n');
    };
    while (lines() < 2 && !ended()) std::this_thread::yield();
    interrupt();
  }
  [[nodiscard]] Outcome wait() const {
    int status = 0;
    waitpid(pid_, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status),
            std::filesystem::is_regular_file(out_) ? read_text(out_) : std::string{}, read_text(err_)};
  }

 private:
  std::filesystem::path out_;
  std::filesystem::path err_;
  pid_t pid_ = -1;
};

/// A child process that begins to write to a pipe and then waits for ever, because nobody reads on.
class StuckChild {
 public:
  explicit StuckChild(const std::vector<std::string>& arguments) {
    std::vector<char*> argv;
    std::vector<std::string> words{test::command()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    int ends[2] = {-1, -1};
    if (pipe(ends) != 0) throw std::runtime_error("no pipe");
    pid_ = fork();
    if (pid_ == 0) {
      signal(SIGINT, SIG_DFL);
      dup2(ends[1], STDOUT_FILENO);
      close(ends[0]);
      close(ends[1]);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(ends[1]);
    reading_ = ends[0];
    char first = 0;
    if (read(reading_, &first, 1) != 1) throw std::runtime_error("the program says nothing");
  }
  StuckChild(const StuckChild&) = delete;
  StuckChild& operator=(const StuckChild&) = delete;
  ~StuckChild() { close(reading_); }
  /// The signal that ended it, after one Ctrl-C; 0 where it ended by itself.
  [[nodiscard]] int signal_after_interrupt() const {
    kill(pid_, SIGINT);
    int status = 0;
    waitpid(pid_, &status, 0);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }

 private:
  pid_t pid_ = -1;
  int reading_ = -1;
};

/// What a terminal of `columns` characters per line shows of a run.
inline std::string on_terminal(const std::vector<std::string>& arguments, unsigned short columns) {
  std::vector<char*> argv;
  std::vector<std::string> words{test::command()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const winsize size{24, columns, 0, 0};
  int terminal = -1;
  const pid_t pid = forkpty(&terminal, nullptr, nullptr, &size);
  if (pid == 0) {
    execv(argv[0], argv.data());
    _exit(127);
  }
  std::string seen;
  char part[4096];
  for (ssize_t n = 0; (n = read(terminal, part, sizeof part)) > 0;) seen.append(part, static_cast<std::size_t>(n));
  close(terminal);
  waitpid(pid, nullptr, 0);
  return seen;
}

inline Outcome modsearch(const std::vector<std::string>& arguments, const TemporaryFolder& folder) {
  return Child{arguments, folder.path()}.wait();
}

/// A line for the shell, in which $M is the program and the working folder is `folder`. Of a program that was killed by
/// signal N the shell says 128 + N.
inline int shell(const std::string& line, const TemporaryFolder& folder) {
  const std::string whole = "cd '" + folder.path().string() + "' && M='" + test::command() + "' && " + line;
  const int status = std::system(whole.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace modsearch::testing
