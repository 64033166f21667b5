#include "places.hpp"

#include <cstdlib>

namespace modsearch::test {

std::filesystem::path source_folder() { return MODSEARCH_SOURCE; }

std::string command() { return MODSEARCH_COMMAND; }

std::filesystem::path shared_folder() {
  const char* named = std::getenv("MODSEARCH_SHARED");
  return named != nullptr && *named != '\0' ? std::filesystem::path{named} : source_folder().parent_path() / "shared";
}

}  // namespace modsearch::test
