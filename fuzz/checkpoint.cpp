#include <cstring>
#include <modsearch/problem/files.hpp>
#include <modsearch/solvers/archive.hpp>
#include <modsearch/solvers/crc32c.hpp>
#include <span>

#include "reader.hpp"

namespace {

void get_everything(const std::filesystem::path& file) {
  const modsearch::Archive archive = modsearch::Archive::load(file);
  for (const std::string& name : archive.names()) {
    const auto get = [&](auto&& one) { fuzz::read<modsearch::FileError>([&] { static_cast<void>(one(name)); }); };
    get([&](const std::string& entry) { return archive.bytes(entry); });
    get([&](const std::string& entry) { return archive.integers(entry); });
    get([&](const std::string& entry) { return archive.unsigned_integers(entry); });
    get([&](const std::string& entry) { return archive.floats(entry); });
    get([&](const std::string& entry) { return archive.numbers(entry); });
    get([&](const std::string& entry) { return archive.texts(entry); });
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input = fuzz::text(data, size);
  const auto file = fuzz::as_file(input, "checkpoint");
  fuzz::read<modsearch::FileError>([&] { get_everything(file); });
  // With the checksum that belongs to it: otherwise nothing behind it would ever be reached.
  const std::uint32_t checksum = modsearch::crc32c(std::as_bytes(std::span{input}));
  std::string whole{input};
  whole.append(reinterpret_cast<const char*>(&checksum), sizeof checksum);
  const auto checked = fuzz::as_file(whole, "checkpoint");
  return fuzz::read<modsearch::FileError>([&] { get_everything(checked); });
}
