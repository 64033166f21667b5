#pragma once

#include <cstddef>

namespace modsearch::app {

/// Characters in a line of the terminal at stderr; a usual width where it does not say.
[[nodiscard]] std::size_t terminal_width();

}  // namespace modsearch::app
