#pragma once

#include <fstream>
#include <nlohmann/json.hpp>

#include "places.hpp"

namespace modsearch::testing {

/// What reference_statistics.py wrote down of SciPy, statsmodels and rliable.
inline nlohmann::json reference(const char* part) {
  std::ifstream file{test::source_folder() / "tests/study/reference_statistics.json"};
  return nlohmann::json::parse(file).at(part);
}

}  // namespace modsearch::testing
