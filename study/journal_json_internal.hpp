#pragma once

// The lines of a journal as JSON. Internal to the study floor.

#include <modsearch/problem/json_internal.hpp>
#include <modsearch/study/records.hpp>
#include <nlohmann/json.hpp>
#include <string>

namespace modsearch::detail {

/// `json` as one line with its end.
[[nodiscard]] std::string to_line(const nlohmann::ordered_json& json);

/// Most bytes of a journal: a million runs with their traces.
inline constexpr std::uintmax_t kLargestJournal = std::uintmax_t{1} << 32U;

/// The line that begins a journal.
[[nodiscard]] nlohmann::ordered_json header_line(const StudyFacts& study);
[[nodiscard]] StudyFacts read_header(const JsonCursor& line);

/// {"cell", "event": "start", ..}: number and key.
[[nodiscard]] nlohmann::ordered_json start_line(const CellRecord& cell);
/// The cell that such a line starts.
[[nodiscard]] CellRecord read_start(const JsonCursor& line);

/// How a cell ends: a line {"cell", "event": "improve", ..} for each improvement and one "done", or one "failed".
/// Throws std::invalid_argument for a cell that is only started.
[[nodiscard]] std::string ending_lines(const CellRecord& cell);
/// Adds what such a line says to `cell`.
void read_ending(const JsonCursor& line, CellRecord& cell);

/// Everything that must come out alike when a finished cell is computed again: outcome and trace without the clock.
[[nodiscard]] nlohmann::ordered_json results(const CellRecord& cell);

}  // namespace modsearch::detail
