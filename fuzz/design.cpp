#include <modsearch/problem/files.hpp>

#include "reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto library = modsearch::load_library("workshop");
  const auto file = fuzz::as_file(fuzz::text(data, size), "design.json");
  fuzz::read<modsearch::FileError>([&] { static_cast<void>(modsearch::load_design(file, *library)); });
  return fuzz::read<modsearch::FileError>([&] { static_cast<void>(modsearch::load_witness(file)); });
}
