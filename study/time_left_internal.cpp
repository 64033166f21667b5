#include <modsearch/study/time_left_internal.hpp>

namespace modsearch::detail {

TimeLeft::TimeLeft(const std::vector<PlannedCell>& plan, int jobs) : jobs_{jobs} {
  for (const PlannedCell& cell : plan) ++groups_[{cell.record.key.kind, cell.record.key.label}].waiting;
}

void TimeLeft::add(const CellRecord& cell) {
  Group& group = groups_[{cell.key.kind, cell.key.label}];
  --group.waiting;
  ++group.ended;
  if (cell.outcome) group.seconds += cell.outcome->spent.seconds;
}

std::optional<double> TimeLeft::estimate() const {
  Group all;
  for (const auto& [name, group] : groups_) {
    all.ended += group.ended;
    all.seconds += group.seconds;
  }
  if (all.ended == 0) return std::nullopt;
  double seconds = 0.0;
  for (const auto& [name, group] : groups_) {
    const Group& known = group.ended > 0 ? group : all;
    seconds += static_cast<double>(group.waiting) * known.seconds / static_cast<double>(known.ended);
  }
  return seconds / jobs_;
}

}  // namespace modsearch::detail
