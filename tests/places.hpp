#pragma once

#include <filesystem>
#include <string>

/// Where things lie that tests read and run. Only places.cpp knows the folders of this build, so that a test compiles
/// to the same object wherever the source tree stands, and a compiler cache serves a second checkout.
namespace modsearch::test {

/// The source tree.
std::filesystem::path source_folder();

/// The program `modsearch` of this build.
std::string command();

/// The folder of recorded data that is not part of this repository: $MODSEARCH_SHARED, or else `shared` beside the
/// source tree. It may not exist; a test that needs it then skips itself and says so.
std::filesystem::path shared_folder();

}  // namespace modsearch::test
