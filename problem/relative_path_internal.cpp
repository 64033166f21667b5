#include <modsearch/problem/relative_path_internal.hpp>

namespace modsearch::detail {
namespace {

/// The folder itself, links followed; what does not exist yet is taken as it is written.
std::filesystem::path real(const std::filesystem::path& folder) {
  const std::filesystem::path absolute = std::filesystem::absolute(folder);
  std::error_code failed;
  std::filesystem::path result = std::filesystem::weakly_canonical(absolute, failed);
  return failed ? absolute.lexically_normal() : result;
}

}  // namespace

std::string relative_to(const std::filesystem::path& file, const std::filesystem::path& folder) {
  // The file keeps its name, also where that is a link: the kind of a mesh is told by the ending.
  const std::filesystem::path absolute = std::filesystem::absolute(file);
  const std::filesystem::path from = real(folder);
  return (real(absolute.parent_path()) / absolute.filename()).lexically_relative(from).generic_string();
}

}  // namespace modsearch::detail
