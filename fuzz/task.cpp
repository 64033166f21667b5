#include <modsearch/problem/files.hpp>

#include "reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = fuzz::as_file(fuzz::text(data, size), "task.json");
  return fuzz::read<modsearch::FileError>([&] { static_cast<void>(modsearch::load_task(file)); });
}
