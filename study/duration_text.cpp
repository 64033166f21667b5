#include <fmt/format.h>

#include <cmath>
#include <modsearch/study/duration_text.hpp>

namespace modsearch {

std::string duration_text(double seconds) {
  if (!std::isfinite(seconds)) return "∞";
  if (seconds < 0.9995e-3) return fmt::format("{:.3g} us", 1e6 * seconds);
  return seconds < 0.9995 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} s", seconds);
}

}  // namespace modsearch
