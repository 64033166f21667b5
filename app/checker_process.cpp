#include "app/checker_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

extern char** environ;

namespace modsearch::app {
namespace {

[[noreturn]] void cannot_run(const std::filesystem::path& program, int error) {
  throw std::invalid_argument(fmt::format("{}, which has to stand beside modsearch, cannot be run: {}",
                                          program.string(), std::strerror(error)));
}

// A child whose standard output is read through a pipe; killed and waited for in the end.
class Child {
 public:
  Child(const std::filesystem::path& program, const std::string& file) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) cannot_run(program, errno);
    read_ = ends[0];
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    std::string path = program.string();
    std::string json = "--json";
    std::string argument = file;
    char* const arguments[] = {path.data(), json.data(), argument.data(), nullptr};
    const int error = ::posix_spawn(&pid_, path.c_str(), &actions, nullptr, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    if (error != 0) {
      ::close(read_);
      cannot_run(program, error);
    }
  }
  ~Child() {
    if (!waited_) {
      ::kill(pid_, SIGKILL);
      static_cast<void>(wait());
    }
    ::close(read_);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  // What it printed within `milliseconds`, added to `text`. False: it has nothing more to say.
  [[nodiscard]] bool listen(int milliseconds, std::string& text) {
    pollfd wanted{read_, POLLIN, 0};
    if (::poll(&wanted, 1, milliseconds) <= 0) return true;
    std::array<char, 4096> buffer{};
    const ssize_t n = ::read(read_, buffer.data(), buffer.size());
    if (n > 0) text.append(buffer.data(), static_cast<std::size_t>(n));
    return n > 0 || (n < 0 && errno == EINTR);
  }

  // Its exit status; -1: a signal ended it.
  [[nodiscard]] int wait() {
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    waited_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t pid_ = -1;
  int read_ = -1;
  bool waited_ = false;
};

CheckerVerdict verdict_of(int status, const std::string& output) {
  const nlohmann::json json = nlohmann::json::parse(output, nullptr, false);
  const auto text = [&](const char* key) {
    return json.is_object() && json.contains(key) && json[key].is_string() ? json[key].get<std::string>()
                                                                           : std::string{};
  };
  if (status == 0 && text("verdict") == "accepted") return {CheckerVerdict::Kind::kAccepted};
  const std::string reason = text("reason");
  return {CheckerVerdict::Kind::kRefused,
          reason.empty() ? fmt::format("modsearch-check ended with status {}", status) : reason};
}

}  // namespace

std::filesystem::path checker_program() {
  std::error_code error;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", error);
  return own.parent_path() / "modsearch-check";
}

CheckerVerdict run_checker(const std::filesystem::path& file, double seconds, std::stop_token stop) {
  const auto start = std::chrono::steady_clock::now();
  const auto taken = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  Child child{checker_program(), file.string()};
  std::string output;
  while (child.listen(50, output)) {
    const bool late = taken() > seconds;
    if (!late && !stop.stop_requested()) continue;
    const std::string why = late ? fmt::format("modsearch-check was not done after {:g} s", seconds) : "interrupted";
    return {CheckerVerdict::Kind::kNotDone, why, taken()};
  }
  const int status = child.wait();
  if (stop.stop_requested()) return {CheckerVerdict::Kind::kNotDone, "interrupted", taken()};
  CheckerVerdict verdict = verdict_of(status, output);
  verdict.seconds = taken();
  return verdict;
}

}  // namespace modsearch::app
