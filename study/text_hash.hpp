#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace modsearch {

/// FNV-1a, 64 bits (Fowler, Noll and Vo; RFC 9923): equal on every machine, good for names, no protection against
/// somebody who looks for collisions.
[[nodiscard]] std::uint64_t fnv1a64(std::string_view bytes);

/// The same as 16 hexadecimal digits.
[[nodiscard]] std::string text_hash(std::string_view bytes);

}  // namespace modsearch
