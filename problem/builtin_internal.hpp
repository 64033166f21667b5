#pragma once

#include <span>
#include <string_view>

namespace modsearch::detail {

/// A file of data/ that is compiled in, so that an installed program needs none.
struct BuiltinFile {
  std::string_view id;    ///< "seed/fixed"
  std::string_view text;  ///< its JSON
};

/// In the order of their IDs; defined in a source that the build writes.
extern const std::span<const BuiltinFile> kBuiltinLibraries;
extern const std::span<const BuiltinFile> kBuiltinProblems;
extern const std::span<const BuiltinFile> kBuiltinStudies;

}  // namespace modsearch::detail
