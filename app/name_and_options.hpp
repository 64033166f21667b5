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

}  // namespace modsearch::app
