#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <modsearch/study/journal_json_internal.hpp>
#include <utility>

namespace modsearch {
namespace {

// A journal as it is read, line by line.
class Reading {
 public:
  explicit Reading(StudyFacts study) { record_.study = std::move(study); }

  void add(const detail::JsonCursor& line) {
    const std::string id = line.at("cell").text();
    const std::string event = line.at("event").text();
    if (event == "start") return start(line);
    const auto found = places_.find(id);
    if (found == places_.end()) line.at("cell").fail_value("a cell that was started");
    CellRecord& cell = record_.cells[found->second];
    if (event == "improve") {
      traces_[id].push_back(detail::read_improvement(line));
    } else if (event == "done") {
      finish(line, cell);
    } else if (event == "failed") {
      if (cell.state == CellState::kDone) return;
      cell.state = CellState::kFailed;
      detail::read_failure(line, cell);
    } else {
      line.at("event").fail_value("one of \"start\", \"improve\", \"done\", \"failed\"");
    }
  }

  [[nodiscard]] StudyRecord result() && {
    std::stable_sort(record_.cells.begin(), record_.cells.end(),
                     [](const CellRecord& a, const CellRecord& b) { return a.number < b.number; });
    return std::move(record_);
  }

 private:
  // A cell is started again where the program was killed before it ended, or where it failed.
  void start(const detail::JsonCursor& line) {
    CellRecord cell = detail::read_start(line);
    traces_[cell.id].clear();
    const auto [place, is_new] = places_.emplace(cell.id, record_.cells.size());
    if (is_new) {
      record_.cells.push_back(std::move(cell));
    } else if (record_.cells[place->second].state == CellState::kFailed) {
      record_.cells[place->second] = std::move(cell);
    }
  }

  void finish(const detail::JsonCursor& line, CellRecord& cell) {
    CellRecord again = cell;
    again.state = CellState::kDone;
    again.outcome = detail::read_outcome(line);
    again.trace = std::exchange(traces_[cell.id], {});
    const std::optional<std::string> differs = cell.key.timed() ? std::nullopt : difference(cell, again);
    if (differs) line.fail(fmt::format("cell {} was done twice with different results: {}", cell.id, *differs));
    if (cell.state != CellState::kDone) cell = std::move(again);
  }

  StudyRecord record_;
  std::map<std::string, std::size_t> places_;              // of cells by their IDs
  std::map<std::string, std::vector<Improvement>> traces_;  // of computations that have not ended
};

}  // namespace

StudyRecord read_journal(const std::filesystem::path& file) {
  const std::string text = detail::read_text(file, file.string(), detail::kLargestJournal);
  std::string_view rest = std::string_view{text}.substr(0, text.rfind('\n') + 1);
  std::optional<Reading> reading;
  for (std::int64_t number = 1; !rest.empty(); ++number) {
    const std::size_t end = rest.find('\n');
    const detail::JsonDocument document =
        detail::parse_json(std::string{rest.substr(0, end)}, {fmt::format("{}: line {}", file.string(), number), {}});
    rest.remove_prefix(end + 1);
    if (reading) {
      reading->add(document.cursor());
    } else {
      reading.emplace(detail::read_header(document.cursor()));
    }
  }
  if (!reading) throw FileError(fmt::format("{}: is empty, not the journal of a study", file.string()));
  return std::move(*reading).result();
}

}  // namespace modsearch
