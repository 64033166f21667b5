#pragma once

#include <cstdlib>
#include <filesystem>

namespace modsearch::test {

/// The folder of recorded data that is not part of this repository: $MODSEARCH_SHARED, or else `shared` beside the source
/// tree. It may not exist; a test that needs it then skips itself and says so.
inline std::filesystem::path shared_folder() {
  const char* named = std::getenv("MODSEARCH_SHARED");
  return named != nullptr && *named != '\0' ? named : MODSEARCH_DEFAULT_SHARED;
}

}  // namespace modsearch::test
