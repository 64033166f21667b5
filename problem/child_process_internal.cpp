#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <exception>
#include <fstream>
#include <modsearch/problem/child_process_internal.hpp>
#include <stdexcept>
#include <string_view>

namespace modsearch::detail {
namespace {

// A mesh of a million triangles takes a tenth of this; damaged ones of a kilobyte have asked for 6 GiB.
constexpr ::rlim_t kMostMemory = ::rlim_t{4} << 30U;
constexpr ::rlim_t kMostSeconds = 60;

// The first byte of an answer.
constexpr char kValue = 'v';
constexpr char kThrown = 't';

void limit(int resource, ::rlim_t most) {
  ::rlimit limits{};
  ::getrlimit(resource, &limits);
  limits.rlim_cur = std::min(limits.rlim_max, most);
  ::setrlimit(resource, &limits);
}

/// Address space of this process [bytes].
::rlim_t address_space() {
  ::rlim_t pages = 0;
  std::ifstream{"/proc/self/statm"} >> pages;
  return pages * static_cast<::rlim_t>(::sysconf(_SC_PAGESIZE));
}

/// A crash is an answer: no core is dumped, and no handler that the program has for its own crashes runs.
void die_quietly_and_within_limits() {
  for (const int signal : {SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGSEGV, SIGXCPU, SIGTERM}) std::signal(signal, SIG_DFL);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, kMostSeconds);
  limit(RLIMIT_AS, address_space() + kMostMemory);
}

std::string answer_of(const std::function<std::string()>& work) {
  try {
    return kValue + work();
  } catch (const std::exception& error) {
    return kThrown + std::string{error.what()};
  }
}

void send(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ::ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return;  // nobody listens any more
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

/// All that comes until the last one who could write is gone.
std::string receive(int descriptor) {
  std::string text;
  std::array<char, 65536> part{};
  while (true) {
    const ::ssize_t n = ::read(descriptor, part.data(), part.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return text;
    text.append(part.data(), static_cast<std::size_t>(n));
  }
}

/// How the process ended, in words; empty: of itself.
std::string reap(::pid_t process) {
  int status = 0;
  while (::waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) return {};  // the program lets the system reap its children: the answer alone tells
  }
  if (WIFSIGNALED(status)) {
    return fmt::format("signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
  }
  return WEXITSTATUS(status) == 0 ? std::string{} : fmt::format("status {}", WEXITSTATUS(status));
}

[[noreturn]] void run_as_child(::pid_t parent, int descriptor, const std::function<std::string()>& work) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);  // it went before the line above
  die_quietly_and_within_limits();
  const std::string answer = answer_of(work);
  const std::uint64_t size = answer.size();  // an answer that breaks off is none
  send(descriptor, {reinterpret_cast<const char*>(&size), sizeof size});
  send(descriptor, answer);
  ::_exit(0);  // what the parent has in its buffers is not for us to write
}

}  // namespace

std::string in_child_process(const std::function<std::string()>& work) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw std::runtime_error(fmt::format("there is no pipe to be had: {}", std::strerror(errno)));
  }
  const ::pid_t parent = ::getpid();
  const ::pid_t process = ::fork();
  if (process == 0) run_as_child(parent, ends[1], work);
  const int error = errno;
  ::close(ends[1]);
  if (process < 0) {
    ::close(ends[0]);
    throw std::runtime_error(fmt::format("there is no process to be had: {}", std::strerror(error)));
  }
  const std::string message = receive(ends[0]);
  ::close(ends[0]);
  const std::string end = reap(process);

  std::uint64_t size = 0;
  if (message.size() > sizeof size) std::memcpy(&size, message.data(), sizeof size);
  if (!end.empty() || size == 0 || message.size() - sizeof size != size) {
    throw std::runtime_error(fmt::format("its reader ended with {}", end.empty() ? "half an answer" : end));
  }
  const std::string_view answer = std::string_view{message}.substr(sizeof size);
  if (answer.front() == kThrown) throw std::runtime_error(std::string{answer.substr(1)});
  return std::string{answer.substr(1)};
}

}  // namespace modsearch::detail
