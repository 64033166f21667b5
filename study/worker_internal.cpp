#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <modsearch/study/journal_json_internal.hpp>
#include <modsearch/study/worker_internal.hpp>
#include <stdexcept>
#include <utility>

namespace modsearch::detail {
namespace {

[[noreturn]] void refuse(const char* what) {
  throw std::runtime_error(fmt::format("no {} for another cell: {}", what, std::strerror(errno)));
}

CellRecord failed(CellRecord cell, std::string what, std::optional<int> signal = std::nullopt) {
  cell.state = CellState::kFailed;
  cell.failure = std::move(what);
  cell.signal = signal;
  cell.outcome.reset();
  cell.trace.clear();
  return cell;
}

CellRecord computed(const CellRecord& cell, const std::function<CellRecord()>& compute) {
  try {
    return compute();
  } catch (const std::exception& error) {
    return failed(cell, error.what());
  } catch (...) {
    return failed(cell, "it threw something that is no std::exception");
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

// Waits for the process; its status as waitpid gives it.
int reap(::pid_t process) {
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

Worker::Worker(const CellRecord& cell, const std::function<CellRecord()>& compute) : cell_{cell} {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) refuse("pipe");
  const ::pid_t parent = ::getpid();
  process_ = ::fork();
  if (process_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);  // it went before the line above
    send(ends[1], ending_lines(computed(cell, compute)));
    ::_exit(0);  // what the parent has in its buffers is not for us to write
  }
  const int error = errno;
  ::close(ends[1]);
  descriptor_ = ends[0];
  if (process_ > 0) return;
  ::close(descriptor_);
  errno = error;
  refuse("process");
}

Worker::Worker(Worker&& other) noexcept { swap(other); }

Worker& Worker::operator=(Worker&& other) noexcept {
  swap(other);
  return *this;
}

void Worker::swap(Worker& other) noexcept {
  std::swap(cell_, other.cell_);
  std::swap(process_, other.process_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(text_, other.text_);
}

Worker::~Worker() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (process_ < 0) return;
  ::kill(process_, SIGKILL);
  reap(process_);
}

bool Worker::receive() {
  std::array<char, 65536> part{};
  const ::ssize_t n = ::read(descriptor_, part.data(), part.size());
  if (n < 0) return errno != EINTR;
  text_.append(part.data(), static_cast<std::size_t>(n));
  return n == 0;
}

CellRecord Worker::result() {
  const int status = reap(std::exchange(process_, -1));
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return failed(cell_, fmt::format("killed by signal {} ({})", signal, ::strsignal(signal)), signal);
  }
  CellRecord cell = cell_;
  for (std::string_view rest = text_; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const JsonDocument line = parse_json(std::string{rest.substr(0, end)}, {"cell " + cell.id, {}});
    rest.remove_prefix(std::min(end + 1, rest.size()));
    read_ending(line.cursor(), cell);
  }
  if (cell.state != CellState::kStarted) return cell;
  return failed(cell_, fmt::format("its process ended with status {} and without a result", WEXITSTATUS(status)));
}

}  // namespace modsearch::detail
