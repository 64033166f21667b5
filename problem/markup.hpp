#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace modsearch {

/// Text as the content of an element or an attribute of XML or HTML. Tabs and line breaks stay what they are;
/// characters that no markup can hold, escaped or not (XML 1.0, section 2.2), become U+FFFD.
[[nodiscard]] std::string markup_safe(std::string_view text);

/// The first of those characters in `text`, as "U+0007"; none where markup can hold all of it.
[[nodiscard]] std::optional<std::string> not_in_markup(std::string_view text);

}  // namespace modsearch
