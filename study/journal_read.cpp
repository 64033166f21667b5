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
    CellRecord& running = running_[id];
    detail::read_ending(line, running);
    if (running.state != CellState::kStarted) end(line, record_.cells[found->second], running);
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
    running_[cell.id] = cell;
    const auto [place, is_new] = places_.emplace(cell.id, record_.cells.size());
    if (is_new) {
      record_.cells.push_back(std::move(cell));
    } else if (record_.cells[place->second].state == CellState::kFailed) {
      record_.cells[place->second] = std::move(cell);
    }
  }

  // The first result stands; another must agree with it.
  static void end(const detail::JsonCursor& line, CellRecord& known, const CellRecord& ended) {
    const std::optional<std::string> differs = known.key.timed() ? std::nullopt : difference(known, ended);
    if (differs) line.fail(fmt::format("cell {} was done twice with different results: {}", known.id, *differs));
    if (known.state != CellState::kDone) known = ended;
  }

  StudyRecord record_;
  std::map<std::string, std::size_t> places_;   // of cells by their IDs
  std::map<std::string, CellRecord> running_;  // what the latest computation of each has told so far
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
