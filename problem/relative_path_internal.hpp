#pragma once

// How a file that is written names another one. Internal to the problem floor.

#include <filesystem>
#include <string>

namespace modsearch::detail {

/// `file` as a file in `folder` names it, in the folders that really are there: ".." leaves the folder that a link
/// leads to, not the one that the link lies in.
[[nodiscard]] std::string relative_to(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace modsearch::detail
