#pragma once

#include <string>
#include <utility>
#include <vector>

namespace modsearch::app {

/// What people write as "name" or "name:key=value,key=value".
struct NameAndOptions {
  std::string name;
  std::vector<std::pair<std::string, std::string>> options;  ///< as given, each key once
};

/// `what`: "solver" or "agent", for messages.
/// Throws std::invalid_argument for a part that is not key=value, and for a key given twice.
[[nodiscard]] NameAndOptions parse_name_and_options(const std::string& text, const std::string& what);

/// "name:key=value,key=value" with the keys sorted: one text for all ways to write the same.
[[nodiscard]] std::string canonical(NameAndOptions parsed);

}  // namespace modsearch::app
