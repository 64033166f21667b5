#pragma once

#include <span>
#include <string_view>

namespace modsearch_check {

/// A file of data/, embedded as text.
struct BuiltinFile {
  std::string_view id;
  std::string_view text;
};

extern const std::span<const BuiltinFile> kBuiltinLibraries;
extern const std::span<const BuiltinFile> kBuiltinProblems;

}  // namespace modsearch_check
