#include "app/standard_streams.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <csignal>

namespace modsearch::app {
namespace {

bool is_closed(int descriptor) { return ::fcntl(descriptor, F_GETFD) == -1 && errno == EBADF; }

// Lower numbers are taken, so that what is opened gets `descriptor`.
void occupy(int descriptor) {
  const int direction = descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY;  // stdout: each write fails
  constexpr int kFailure = 3;
  if (::open("/dev/null", direction) != descriptor && ::open("/", O_RDONLY) != descriptor) ::_exit(kFailure);
}

bool takes_more() {
  ::pollfd polled{STDERR_FILENO, POLLOUT, 0};
  return ::poll(&polled, 1, 0) == 1 && (polled.revents & POLLOUT) != 0;
}

void write_while(std::string_view text, bool (*ready)()) noexcept {
  while (!text.empty() && ready()) {
    const std::size_t part = std::min<std::size_t>(text.size(), PIPE_BUF);  // what a pipe that is ready takes at once
    const ::ssize_t written = ::write(STDERR_FILENO, text.data(), part);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;  // a diagnostic that nobody can read is no reason to end
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

}  // namespace

void secure_standard_streams() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (is_closed(descriptor)) occupy(descriptor);
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

void tell(std::string_view text) noexcept { write_while(text, takes_more); }

void tell_at_last(std::string_view text) noexcept {
  write_while(text, [] { return true; });
}

}  // namespace modsearch::app
