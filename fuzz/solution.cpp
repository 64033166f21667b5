#include <modsearch/problem/files.hpp>

#include "reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = fuzz::as_file(fuzz::text(data, size), "solution.json");
  fuzz::read<modsearch::FileError>([&] { static_cast<void>(modsearch::load_solution(file)); });
  // The form of CoBRA, which names no problem.
  return fuzz::read<modsearch::FileError>([&] { static_cast<void>(modsearch::load_solution(file, "seed/fixed")); });
}
