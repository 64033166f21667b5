#include <algorithm>
#include <modsearch/problem/files.hpp>
#include <modsearch/rl/saved_policy.hpp>

#include "reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // The description up to the first zero byte, then the weights, which it has to name "weights.bin".
  const std::string_view input = fuzz::text(data, size);
  const std::size_t end = std::min(input.find(char{0}), input.size());
  fuzz::as_file(input.substr(std::min(end + 1, input.size())), "weights.bin");
  const auto file = fuzz::as_file(input.substr(0, end), "policy.json");
  return fuzz::read<modsearch::FileError>([&] { static_cast<void>(modsearch::load_trained_policy(file)); });
}
