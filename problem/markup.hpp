#pragma once

#include <string>
#include <string_view>

namespace modsearch {

/// Text as the content of an element or an attribute of XML or HTML.
[[nodiscard]] std::string markup_safe(std::string_view text);

}  // namespace modsearch
