#include <app/study_names.hpp>
#include <modsearch/problem/files.hpp>

#include "reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const modsearch::StudyNames names = modsearch::app::study_names();
  const auto file = fuzz::as_file(fuzz::text(data, size), "study.json");
  return fuzz::read<modsearch::FileError>([&] { static_cast<void>(modsearch::load_study(file.string(), names)); });
}
