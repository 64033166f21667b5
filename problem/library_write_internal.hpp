#pragma once

// Module libraries as files write them. Internal to the problem floor.

#include <modsearch/problem/json_internal.hpp>
#include <modsearch/problem/module_library.hpp>

namespace modsearch::detail {

/// How a library is written.
struct LibraryStyle {
  std::filesystem::path folder = ".";  ///< where the file will lie: meshes are named relative to it
  bool bare_infinity = false;  ///< limits that are infinite stand there as Timor has them, instead of being left out
};

/// The library: base first, then the types in their order. Throws std::invalid_argument for a number of several
/// parameters and for a capsule, which only programs can make. The text goes through with_bare_infinity.
[[nodiscard]] nlohmann::ordered_json to_json(const ModuleLibrary& library, const LibraryStyle& style);
/// What stands for an infinite limit in a document.
[[nodiscard]] std::string infinity_mark(double limit);
/// `text` with every such mark as Infinity.
[[nodiscard]] std::string with_bare_infinity(std::string text);

}  // namespace modsearch::detail
