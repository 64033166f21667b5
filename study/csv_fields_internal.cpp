#include "csv_fields_internal.hpp"

#include <fmt/format.h>

#include <cmath>

namespace modsearch {

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string{"\"\""} : std::string{c};
  return quoted + '"';
}

std::string csv_field(double number) {
  if (std::isfinite(number)) return fmt::format("{}", number);
  return std::isnan(number) ? "NaN" : number > 0.0 ? "Inf" : "-Inf";
}

}  // namespace modsearch
