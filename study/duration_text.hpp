#pragma once

#include <string>

namespace modsearch {

/// Three digits in the unit that fits: "12.3 us", "4.56 ms", "78.9 s"; infinity is "∞".
[[nodiscard]] std::string duration_text(double seconds);

}  // namespace modsearch
