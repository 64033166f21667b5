#include "app/agent_choice.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <stdexcept>

#include "app/name_and_options.hpp"

namespace modsearch::app {

ChosenAgent choose_agent(const std::string& text, const ProblemFile& problem) {
  const NameAndOptions parsed = parse_name_and_options(text, "agent");
  const std::optional<AgentKind> kind = agent_kind_from_name(parsed.name);
  if (!kind) {
    std::vector<std::string_view> known;
    for (const AgentKind each : agent_kinds()) known.push_back(name(each));
    throw std::invalid_argument(fmt::format("agent '{}' is not one of {}", parsed.name, fmt::join(known, ", ")));
  }
  ChosenAgent chosen{canonical(parsed), "report", {}};
  for (const auto& [key, value] : parsed.options) {
    if (key == "preset") chosen.preset = value;
  }
  const std::optional<Preset> preset = preset_from_name(chosen.preset);
  if (!preset) {
    throw std::invalid_argument(
        fmt::format("agent option preset={}: not one of report, report-code, best", chosen.preset));
  }
  chosen.settings = settings_of(*kind, *preset, traits_of(problem));
  for (const auto& [key, value] : parsed.options) {
    if (key != "preset") apply_setting(chosen.settings, key, value);
  }
  chosen.settings.environment.hindsight_region = problem.sampling;
  return chosen;
}

}  // namespace modsearch::app
