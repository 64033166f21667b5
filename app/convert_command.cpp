#include <modsearch/problem/convert.hpp>

#include "app/commands.hpp"
#include "app/output_internal.hpp"

namespace modsearch::app {

Status convert(const ConvertArguments& arguments, const CommonArguments& common) {
  if (arguments.out.empty()) throw std::invalid_argument("OUT is empty: not the name of a file");
  const std::string by_ending = arguments.out.extension() == ".urdf" ? "urdf" : "modsearch";
  const FileFormat to = file_format_from_name(arguments.to.value_or(by_ending)).value();
  const std::filesystem::path folder = arguments.out.has_parent_path() ? arguments.out.parent_path() : ".";
  write_file(arguments.out,
             modsearch::convert(
                 arguments.in,
                 {.to = to, .library = arguments.library, .folder = folder, .mesh_root = common.files.mesh_root}));
  if (common.json) {
    print({{"format", name(to)}, {"files", {arguments.out.string()}}});
  } else {
    say("wrote        {}\n", arguments.out.string());
  }
  return Status::kSuccess;
}

}  // namespace modsearch::app
