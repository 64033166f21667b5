#include <array>
#include <modsearch/solvers/crc32c.hpp>

namespace modsearch {
namespace {

// Eight tables, so that eight bytes take eight look-ups that do not wait for each other (Kounavis and Berry 2005, "A
// systematic approach to building high performance software-based CRC generators"): table k advances a byte over k
// zeros. Checkpoints have hundreds of megabytes.
using Tables = std::array<std::array<std::uint32_t, 256>, 8>;

constexpr Tables make_tables() {
  constexpr std::uint32_t kReflectedPolynomial = 0x82F63B78;
  Tables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t remainder = byte;
    for (int bit = 0; bit < 8; ++bit) remainder = (remainder >> 1) ^ ((remainder & 1) != 0 ? kReflectedPolynomial : 0);
    tables[0][byte] = remainder;
  }
  for (std::size_t k = 1; k < tables.size(); ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t previous = tables[k - 1][byte];
      tables[k][byte] = (previous >> 8) ^ tables[0][previous & 0xFF];
    }
  }
  return tables;
}

constexpr Tables kTables = make_tables();

}  // namespace

std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before) {
  const auto at = [&](std::size_t i) { return std::to_integer<std::uint32_t>(bytes[i]); };
  std::uint32_t remainder = ~before;
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {
    remainder ^= at(i) | at(i + 1) << 8 | at(i + 2) << 16 | at(i + 3) << 24;
    remainder = kTables[7][remainder & 0xFF] ^ kTables[6][remainder >> 8 & 0xFF] ^ kTables[5][remainder >> 16 & 0xFF] ^
                kTables[4][remainder >> 24] ^ kTables[3][at(i + 4)] ^ kTables[2][at(i + 5)] ^ kTables[1][at(i + 6)] ^
                kTables[0][at(i + 7)];
  }
  for (; i < bytes.size(); ++i) remainder = (remainder >> 8) ^ kTables[0][(remainder ^ at(i)) & 0xFF];
  return ~remainder;
}

}  // namespace modsearch
