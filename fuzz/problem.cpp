#include <modsearch/problem/files.hpp>
#include <optional>

#include "reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = fuzz::as_file(fuzz::text(data, size), "problem.json");
  std::optional<modsearch::ProblemFile> problem;
  fuzz::read<modsearch::FileError>([&] { problem = modsearch::load_problem_file(file.string()); });
  if (!problem) return 0;
  // Drawing an instance throws std::runtime_error where every place for its target is too near to an obstacle.
  return fuzz::read<std::runtime_error>([&] { static_cast<void>(problem->instance({.seed = 0, .index = 1})); });
}
