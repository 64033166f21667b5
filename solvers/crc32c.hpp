#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace modsearch {

/// CRC-32C of `bytes` (Castagnoli's polynomial 0x1EDC6F41, reflected, complemented at both ends; RFC 3720, section 12.1
/// and appendix B.4). `before`: checksum of what precedes `bytes`, 0 for nothing, so that
/// crc32c(b, crc32c(a)) == crc32c(ab).
[[nodiscard]] std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before = 0);

}  // namespace modsearch
