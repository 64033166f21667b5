#include <fmt/format.h>

#include <algorithm>
#include <modsearch/problem/builtin_internal.hpp>
#include <modsearch/problem/readers_internal.hpp>

namespace modsearch {
namespace detail {
namespace {

std::optional<std::string_view> text_of(std::span<const BuiltinFile> files, std::string_view id) {
  const auto found = std::find_if(files.begin(), files.end(), [&](const BuiltinFile& file) { return file.id == id; });
  if (found == files.end()) return std::nullopt;
  return found->text;
}

std::vector<std::string> ids(std::span<const BuiltinFile> files) {
  std::vector<std::string> result;
  for (const BuiltinFile& file : files) result.emplace_back(file.id);
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace

std::optional<std::string_view> builtin_library(std::string_view id) { return text_of(kBuiltinLibraries, id); }
std::optional<std::string_view> builtin_problem(std::string_view id) { return text_of(kBuiltinProblems, id); }

void require_file_or_id(const std::filesystem::path& file, std::string_view what,
                        const std::vector<std::string>& known) {
  std::error_code error;
  if (std::filesystem::exists(file, error) || error) return;  // what is wrong with a file is said by its reader
  std::string list;
  for (const std::string& id : known) list += (list.empty() ? "" : ", ") + id;
  throw FileError(
      fmt::format("{}: there is no such file and no built-in {} with this ID (known: {})", file.string(), what, list));
}

}  // namespace detail

std::vector<std::string> builtin_problems() { return detail::ids(detail::kBuiltinProblems); }
std::vector<std::string> builtin_libraries() { return detail::ids(detail::kBuiltinLibraries); }

}  // namespace modsearch
