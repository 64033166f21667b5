#pragma once

#include <stop_token>

namespace modsearch::app {

/// From now on Ctrl-C (and SIGTERM) asks the returned token to stop instead of ending the program; a second one ends it
/// at once with status 130. To be called once, by a command that looks at the token, before it starts any thread: a
/// thread of its own waits for the signals, because a handler may do next to nothing.
[[nodiscard]] std::stop_token stop_on_interrupt();

}  // namespace modsearch::app
