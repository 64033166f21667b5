#include <fmt/format.h>

#include <modsearch/study/text_hash.hpp>

namespace modsearch {

std::uint64_t fnv1a64(std::string_view bytes) {
  constexpr std::uint64_t kOffsetBasis = 0xcbf29ce484222325U;
  constexpr std::uint64_t kPrime = 0x100000001b3U;
  std::uint64_t hash = kOffsetBasis;
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * kPrime;
  return hash;
}

std::string text_hash(std::string_view bytes) { return fmt::format("{:016x}", fnv1a64(bytes)); }

}  // namespace modsearch
