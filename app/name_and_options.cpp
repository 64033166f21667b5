#include "app/name_and_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace modsearch::app {

NameAndOptions parse_name_and_options(const std::string& text, const std::string& what) {
  const std::size_t colon = text.find(':');
  NameAndOptions result{text.substr(0, colon), {}};
  std::size_t at = colon == std::string::npos ? text.size() + 1 : colon + 1;
  while (at <= text.size()) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const std::string pair = text.substr(at, comma - at);
    const std::size_t equals = pair.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw std::invalid_argument(fmt::format("{} option '{}' is not of the form key=value", what, pair));
    }
    const std::string key = pair.substr(0, equals);
    const bool twice = std::any_of(result.options.begin(), result.options.end(),
                                   [&](const auto& option) { return option.first == key; });
    if (twice) throw std::invalid_argument(fmt::format("{} option '{}' is given twice", what, key));
    result.options.emplace_back(key, pair.substr(equals + 1));
    at = comma + 1;
  }
  return result;
}

std::string canonical(NameAndOptions parsed) {
  std::sort(parsed.options.begin(), parsed.options.end());
  std::string text = parsed.name;
  for (const auto& [key, value] : parsed.options) {
    text += fmt::format("{}{}={}", text == parsed.name ? ':' : ',', key, value);
  }
  return text;
}

}  // namespace modsearch::app
