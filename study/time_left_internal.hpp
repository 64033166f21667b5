#pragma once

#include <map>
#include <modsearch/study/study.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace modsearch::detail {

/// How long a study will take yet: cells of one kind and solver take about as long as those that have ended.
class TimeLeft {
 public:
  TimeLeft(const std::vector<PlannedCell>& plan, int jobs);
  /// A cell has ended, in this run or in an earlier one.
  void add(const CellRecord& cell);
  /// Seconds; nothing before the first cell has ended.
  [[nodiscard]] std::optional<double> estimate() const;

 private:
  struct Group {
    std::int64_t waiting = 0;
    std::int64_t ended = 0;
    double seconds = 0.0;
  };
  std::map<std::pair<CellKind, std::string>, Group> groups_;
  int jobs_;
};

}  // namespace modsearch::detail
