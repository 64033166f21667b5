#include <fmt/format.h>

#include <cstring>
#include <modsearch/rl/state_archive.hpp>

namespace modsearch {

void put(Archive& archive, const std::string& prefix, std::span<const StatePart> parts) {
  for (const StatePart& part : parts) archive.put(prefix + "/" + part.name, std::span<const std::byte>{part.bytes});
}

void restore(const Archive& archive, const std::string& prefix, std::span<const StatePart> parts) {
  for (const StatePart& part : parts) {
    const std::string name = prefix + "/" + part.name;
    const std::size_t size = archive.bytes(name).size();
    if (size != part.bytes.size()) archive.fail(name, fmt::format("has {} bytes (limit {})", size, part.bytes.size()));
  }
  for (const StatePart& part : parts) {
    const std::span<const std::byte> kept = archive.bytes(prefix + "/" + part.name);
    if (!kept.empty()) std::memcpy(part.bytes.data(), kept.data(), kept.size());
  }
}

}  // namespace modsearch
