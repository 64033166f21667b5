#pragma once

#include <string>

namespace modsearch {

/// `text`, in quotes where CSV needs them (RFC 4180).
[[nodiscard]] std::string csv_field(const std::string& text);
/// The shortest text that reads back as the same number; infinite ones as pandas and R read them.
[[nodiscard]] std::string csv_field(double number);

}  // namespace modsearch
