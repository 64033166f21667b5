#include <checker/certificate.hpp>
#include <checker/json.hpp>
#include <variant>

#include "reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = fuzz::as_file(fuzz::text(data, size), "certificate.json");
  return fuzz::read<modsearch_check::Malformed>([&] {
    fuzz::read<modsearch_check::Rejected>(
        [&] { static_cast<void>(modsearch_check::in_words(modsearch_check::check_certificate(file.string()))); });
  });
}
