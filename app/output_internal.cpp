#include "app/output_internal.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <modsearch/problem/files.hpp>
#include <stdexcept>

#include "app/commands.hpp"

namespace modsearch::app {
namespace {

[[noreturn]] void refuse_output() {
  throw FileError(fmt::format("the standard output cannot be written: {}", std::strerror(errno)));
}

}  // namespace

void write_out(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) refuse_output();
}

void print(const nlohmann::ordered_json& json) {
  // What came from outside, such as the name of a file, need not be UTF-8.
  write_out(json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n');
}

void flush_output() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) refuse_output();
}

bool is_builtin(const std::string& problem) {
  const std::vector<std::string> builtin = builtin_problems();
  return std::find(builtin.begin(), builtin.end(), problem) != builtin.end();
}

std::string problem_reference(const std::string& problem, const std::filesystem::path& folder) {
  if (is_builtin(problem)) return problem;
  return std::filesystem::relative(std::filesystem::absolute(problem), std::filesystem::absolute(folder)).string();
}

void make_folder(const std::filesystem::path& folder) {
  if (folder.empty()) throw std::invalid_argument("--out is empty: not the name of a folder");
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw FileError(fmt::format("{}: cannot make this folder: {}", folder.string(), error.message()));
  // Before the search, not after it.
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    throw FileError(fmt::format("{}: cannot write into this folder: {}", folder.string(), std::strerror(errno)));
  }
}

OutputLock claim_folder(const std::filesystem::path& folder) {
  make_folder(folder);
  return OutputLock::of_folder(folder);
}

}  // namespace modsearch::app
