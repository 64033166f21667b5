#include <fmt/format.h>

#include <algorithm>
#include <modsearch/study/journal_json_internal.hpp>
#include <modsearch/study/records.hpp>
#include <stdexcept>

namespace modsearch {

std::string_view name(CellKind kind) {
  switch (kind) {
    case CellKind::kTraining:
      return "training";
    case CellKind::kBound:
      return "bound";
    case CellKind::kRun:
      return "run";
  }
  throw std::invalid_argument("name: no such CellKind");
}

std::string_view name(CellState state) {
  switch (state) {
    case CellState::kStarted:
      return "started";
    case CellState::kDone:
      return "done";
    case CellState::kFailed:
      return "failed";
  }
  throw std::invalid_argument("name: no such CellState");
}

DesignRecord record_of(const ModuleLibrary& library, const Design& design) {
  check(library, design);
  DesignRecord record;
  for (const Placement& placement : design.modules) {
    const ModuleType& type = library.type(placement.type);
    DesignRecord::Module& module = record.modules.emplace_back();
    module.type = type.id;
    for (int i = 0; i < type.n_parameters(); ++i) {
      module.parameters.emplace(type.parameters[static_cast<std::size_t>(i)].name, placement.parameters[i]);
    }
  }
  return record;
}

Design design_of(const ModuleLibrary& library, const DesignRecord& record) {
  Design design;
  for (const DesignRecord::Module& module : record.modules) {
    const std::optional<int> k = library.find(module.type);
    if (!k) {
      throw std::invalid_argument(fmt::format("design: library '{}' has no module '{}'", library.name(), module.type));
    }
    const std::vector<ParameterRange>& ranges = library.type(*k).parameters;
    Placement placement{*k, Parameters(static_cast<Eigen::Index>(ranges.size()))};
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const auto value = module.parameters.find(ranges[i].name);
      if (value == module.parameters.end() || module.parameters.size() != ranges.size()) {
        throw std::invalid_argument(fmt::format(
            "design: the parameters are not those of module '{}' of library '{}'", module.type, library.name()));
      }
      placement.parameters[static_cast<Eigen::Index>(i)] = value->second;
    }
    design.modules.push_back(std::move(placement));
  }
  check(library, design);
  return design;
}

std::optional<std::string> difference(const CellRecord& first, const CellRecord& second) {
  if (!first.outcome || !second.outcome) return std::nullopt;
  const nlohmann::ordered_json a = detail::results(first);
  const nlohmann::ordered_json b = detail::results(second);
  for (const auto& [key, value] : a.items()) {
    if (b.contains(key) && b[key] == value) continue;
    return fmt::format("{}: {} and {}", key, value.dump(), b.contains(key) ? b[key].dump() : "nothing");
  }
  for (const auto& [key, value] : b.items()) {
    if (!a.contains(key)) return fmt::format("{}: nothing and {}", key, value.dump());
  }
  return std::nullopt;
}

std::int64_t StudyRecord::n_ended() const {
  return std::count_if(cells.begin(), cells.end(),
                       [](const CellRecord& cell) { return cell.state != CellState::kStarted; });
}

const CellRecord* StudyRecord::find(std::string_view id) const {
  const auto found = std::find_if(cells.begin(), cells.end(), [&](const CellRecord& cell) { return cell.id == id; });
  return found == cells.end() ? nullptr : &*found;
}

}  // namespace modsearch
