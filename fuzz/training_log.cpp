#include <modsearch/problem/files.hpp>
#include <modsearch/rl/training_csv.hpp>

#include "reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = fuzz::as_file(fuzz::text(data, size), "training.csv");
  return fuzz::read<modsearch::FileError>([&] { static_cast<void>(modsearch::load_training_csv(file)); });
}
