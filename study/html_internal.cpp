#include <algorithm>
#include <modsearch/study/html_internal.hpp>
#include <stdexcept>

namespace modsearch {

std::string script_safe(const nlohmann::json& json) {
  std::string out;
  for (const char c : json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace)) {
    switch (c) {
      case '<':
        out += "\\u003c";
        break;
      case '>':
        out += "\\u003e";
        break;
      case '&':
        out += "\\u0026";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string fill_html(std::string_view frame, std::span<const std::pair<std::string_view, std::string_view>> parts) {
  std::string out;
  std::string_view rest = frame;
  for (;;) {
    const std::size_t open = rest.find("{{");
    out += rest.substr(0, open);
    if (open == std::string_view::npos) return out;
    const std::size_t close = rest.find("}}", open);
    const std::string_view name = rest.substr(open + 2, close - open - 2);
    const auto part = std::find_if(parts.begin(), parts.end(), [&](const auto& p) { return p.first == name; });
    if (part == parts.end()) throw std::logic_error("the page asks for an unknown part " + std::string(name));
    out += part->second;
    rest.remove_prefix(close + 2);
  }
}

}  // namespace modsearch
