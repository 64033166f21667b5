#include <fmt/format.h>

#include <modsearch/problem/markup.hpp>

namespace modsearch {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD

/// How many bytes at the beginning of `text` are a character that markup cannot hold; 0 if it can. Those are the
/// control characters but tab, line feed and carriage return, and U+FFFE and U+FFFF.
std::size_t forbidden(std::string_view text) {
  const char c = text.front();
  if (c >= '\0' && c < ' ') return c == '\t' || c == '\n' || c == '\r' ? 0 : 1;
  return text.starts_with("\xEF\xBF\xBE") || text.starts_with("\xEF\xBF\xBF") ? 3 : 0;
}

}  // namespace

std::string markup_safe(std::string_view text) {
  std::string out;
  for (; !text.empty(); text.remove_prefix(1)) {
    if (const std::size_t n = forbidden(text); n > 0) {
      out += kReplacement;
      text.remove_prefix(n - 1);
      continue;
    }
    switch (text.front()) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      // As they are, a reader would make spaces of them in an attribute.
      case '\t':
        out += "&#9;";
        break;
      case '\n':
        out += "&#10;";
        break;
      case '\r':
        out += "&#13;";
        break;
      default:
        out += text.front();
    }
  }
  return out;
}

std::optional<std::string> not_in_markup(std::string_view text) {
  for (; !text.empty(); text.remove_prefix(1)) {
    const std::size_t n = forbidden(text);
    if (n == 1) return fmt::format("U+{:04X}", static_cast<unsigned>(text.front()));
    if (n == 3) return text[2] == '\xBE' ? "U+FFFE" : "U+FFFF";
  }
  return std::nullopt;
}

}  // namespace modsearch
