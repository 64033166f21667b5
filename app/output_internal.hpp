#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <modsearch/problem/output_lock.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace modsearch::app {

// Results go to stdout; all of these throw FileError if it cannot be written, say to a full disk.
void write_out(std::string_view text);
void print(const nlohmann::ordered_json& json);
template <typename... Values>
void say(fmt::format_string<Values...> format, Values&&... values) {
  write_out(fmt::format(format, std::forward<Values>(values)...));
}

/// Whether `problem` is the ID of a built-in problem.
[[nodiscard]] bool is_builtin(const std::string& problem);
/// How a file in `folder` names `problem`: files relative to the folder, IDs of built-in problems as they are.
[[nodiscard]] std::string problem_reference(const std::string& problem, const std::filesystem::path& folder);

/// Makes the folder that --out names, before any work is done. Throws std::invalid_argument for an empty name,
/// FileError if it cannot be made or written into.
void make_folder(const std::filesystem::path& folder);
/// The same, and nobody else may write there while the lock is held. Throws FileError if somebody does.
[[nodiscard]] OutputLock claim_folder(const std::filesystem::path& folder);

}  // namespace modsearch::app
