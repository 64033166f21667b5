#pragma once

// What our files need to be files of Timor's and of CoBRA's, as Timor 1.1.1 reads them. Internal to the problem floor.

#include <modsearch/problem/json_internal.hpp>
#include <modsearch/problem/module_library.hpp>

namespace modsearch::detail {

/// Makes a library of modules without parameters Timor's: limits for every joint, names that occur once, and no keys
/// but Timor's, whose readers end at the first one that they do not know.
void settle_for_timor(nlohmann::ordered_json& library);

/// Makes a task CoBRA's: lists where lists are meant, frames of tolerances one by one, and no keys but CoBRA's
/// (`notes`, `acknowledgement` and `publication` are none of a task's).
void settle_for_cobra(nlohmann::ordered_json& task);
/// Refuses what a task of ours may say and one of CoBRA's may not.
void require_cobras_task(const JsonCursor& task);
/// Refuses the date of a header that is not written YYYY-MM-DD: Timor's reader ends at others.
void require_date(const JsonCursor& header, std::string_view format);
/// The folder that files are named from in a task of CoBRA's with this ID which lies in `folder`: the top of its
/// package, for the package keeps it under its ID.
[[nodiscard]] std::filesystem::path package_root(const std::string& id, const std::filesystem::path& folder);

/// Leaves out tolerances from -Infinity (for a radius from 0) to Infinity, which limit nothing and which JSON has no
/// word for.
void drop_free_tolerances(Json& value);

/// Fills in what a solution of CoBRA's has to say and `solution` does not: fixed values, so that equal solutions give
/// equal files. The cost, unless it is given with a cost function of CoBRA's, is the arm's mass.
void settle_solution_for_cobra(nlohmann::ordered_json& solution, const ModuleLibrary& library, double mass);

/// The name by which Timor knows a library: that of the folder of its modules.json, else the file's own name.
[[nodiscard]] std::string module_set(const ModuleLibrary& library);

}  // namespace modsearch::detail
