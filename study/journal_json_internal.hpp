#pragma once

// The lines of a journal as JSON. Internal to the study floor.

#include <modsearch/problem/json_internal.hpp>
#include <modsearch/study/records.hpp>
#include <nlohmann/json.hpp>
#include <string>

namespace modsearch::detail {

/// Most bytes of a journal: a million runs with their traces.
inline constexpr std::uintmax_t kLargestJournal = std::uintmax_t{1} << 32U;

/// The line that begins a journal.
[[nodiscard]] nlohmann::ordered_json header_line(const StudyFacts& study);
[[nodiscard]] StudyFacts read_header(const JsonCursor& line);

/// {"cell", "event": "start", ..}: number and key.
[[nodiscard]] nlohmann::ordered_json start_line(const CellRecord& cell);
/// The cell that such a line starts.
[[nodiscard]] CellRecord read_start(const JsonCursor& line);

[[nodiscard]] nlohmann::ordered_json improve_line(const std::string& cell, const Improvement& improvement);
[[nodiscard]] Improvement read_improvement(const JsonCursor& line);

/// {"cell", "event": "done", ..}
[[nodiscard]] nlohmann::ordered_json done_line(const std::string& cell, const CellOutcome& outcome);
[[nodiscard]] CellOutcome read_outcome(const JsonCursor& line);

/// {"cell", "event": "failed", ..}
[[nodiscard]] nlohmann::ordered_json failed_line(const CellRecord& cell);
void read_failure(const JsonCursor& line, CellRecord& cell);

/// Everything that must come out alike when a finished cell is computed again: outcome and trace without the clock.
[[nodiscard]] nlohmann::ordered_json results(const CellRecord& cell);

}  // namespace modsearch::detail
