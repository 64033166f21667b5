#pragma once

// Readers of parts of files, shared between the files that may hold or name them. Internal to the problem floor.

#include <modsearch/problem/files.hpp>
#include <modsearch/problem/json_internal.hpp>

namespace modsearch::detail {

/// Text of the built-in library or problem with this ID.
[[nodiscard]] std::optional<std::string_view> builtin_library(std::string_view id);
[[nodiscard]] std::optional<std::string_view> builtin_problem(std::string_view id);
/// Throws FileError, listing the IDs of the built-in ones, if `file`, which is none of them, does not exist either.
void require_file_or_id(const std::filesystem::path& file, std::string_view what,
                        const std::vector<std::string>& known);

/// `name`: ID or file, kept in the library for messages.
[[nodiscard]] std::shared_ptr<const ModuleLibrary> read_library(const JsonCursor& cursor, const std::string& name);
/// A built-in library, or a file relative to the document `referrer` that names it (one without a label: the user).
[[nodiscard]] std::shared_ptr<const ModuleLibrary> load_library_from(const std::string& file_or_id,
                                                                     const JsonSource& referrer);
/// Whether a document is a library in its older form, a bare list of modules.
[[nodiscard]] bool is_list_of_modules(const Json& root);

[[nodiscard]] TaskFile read_task(const JsonCursor& cursor);
/// The task in `text`; `label`: where it comes from, for messages.
[[nodiscard]] TaskFile read_task_text(std::string text, const std::string& label);

[[nodiscard]] std::shared_ptr<const Scoring> read_scoring(const JsonCursor& cursor);

/// A list of {"type", "parameters"}.
[[nodiscard]] Design read_design(const JsonCursor& cursor, const ModuleLibrary& library);
[[nodiscard]] nlohmann::ordered_json to_json(const ModuleLibrary& library, const Design& design);

/// The design that CoBRA's list of modules names, base first: modules without parameters.
[[nodiscard]] Design read_module_order(const JsonCursor& order, const ModuleLibrary& library);
/// CoBRA's description of the assembly: modules by number, base first, and the connectors that join them. What a placed
/// base (base_placement.hpp) stands on is no module there.
void add_assembly(const ModuleLibrary& library, const Design& design, bool placed, nlohmann::ordered_json& out);

}  // namespace modsearch::detail
