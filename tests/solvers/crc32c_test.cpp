#include <gtest/gtest.h>

#include <algorithm>
#include <modsearch/problem/rng.hpp>
#include <modsearch/solvers/crc32c.hpp>
#include <string_view>
#include <vector>

namespace modsearch {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span{text}); }

// RFC 3720, appendix B.4, whose checksums are printed in the order of the bytes sent, the lowest first.
TEST(Crc32c, GivesThePublishedAnswers) {
  std::vector<std::byte> data(32, std::byte{0x00});
  EXPECT_EQ(crc32c(data), 0x8A9136AAU);
  std::fill(data.begin(), data.end(), std::byte{0xFF});
  EXPECT_EQ(crc32c(data), 0x62A8AB43U);
  for (std::size_t i = 0; i < 32; ++i) data[i] = static_cast<std::byte>(i);
  EXPECT_EQ(crc32c(data), 0x46DD794EU);
  std::reverse(data.begin(), data.end());
  EXPECT_EQ(crc32c(data), 0x113FDB5CU);
}

// The check value of CRC-32C in every catalogue of checksums.
TEST(Crc32c, GivesTheCheckValueForTheNineDigits) { EXPECT_EQ(crc32c(bytes_of("123456789")), 0xE3069283U); }

TEST(Crc32c, OfNothingIsZero) { EXPECT_EQ(crc32c({}), 0U); }

TEST(Crc32c, IsThatOfTheDivisionBitByBit) {
  Rng rng{1};
  for (std::size_t length = 0; length < 40; ++length) {
    std::vector<std::byte> data(length);
    for (std::byte& byte : data) byte = static_cast<std::byte>(rng.index(256));
    std::uint32_t remainder = 0xFFFFFFFFU;
    for (const std::byte byte : data) {
      for (int bit = 0; bit < 8; ++bit) {
        const bool one = ((std::to_integer<std::uint32_t>(byte) >> bit ^ remainder) & 1U) != 0;
        remainder = (remainder >> 1) ^ (one ? 0x82F63B78U : 0U);
      }
    }
    EXPECT_EQ(crc32c(data), ~remainder) << length;
  }
}

TEST(Crc32c, ContinuesWhereItWasLeft) {
  const std::string_view text = "a text of some length, cut anywhere";
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    EXPECT_EQ(crc32c(bytes_of(text.substr(cut)), crc32c(bytes_of(text.substr(0, cut)))), crc32c(bytes_of(text)));
  }
}

}  // namespace
}  // namespace modsearch
