#include "app/terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

namespace modsearch::app {

std::size_t terminal_width() {
  winsize size{};
  constexpr std::size_t kUsual = 80;
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

}  // namespace modsearch::app
