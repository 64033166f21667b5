#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace modsearch {

/// JSON that cannot end the script element it stands in: '<', '>' and '&' occur in strings only, where the escape means
/// the same. What is not UTF-8 becomes the replacement character; what is not finite becomes null.
[[nodiscard]] std::string script_safe(const nlohmann::json& json);

/// `frame` with each {{name}} replaced by the part of that name. In one pass, so that nothing inside a part is taken
/// for a place to fill. Throws std::logic_error for a name that no part has.
[[nodiscard]] std::string fill_html(std::string_view frame,
                                    std::span<const std::pair<std::string_view, std::string_view>> parts);

}  // namespace modsearch
