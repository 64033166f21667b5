#pragma once

#include <functional>
#include <modsearch/rl/agent_options.hpp>
#include <modsearch/rl/agents.hpp>
#include <modsearch/rl/design_environment.hpp>
#include <modsearch/rl/training.hpp>
#include <string>
#include <vector>

namespace modsearch {

/// Everything that decides what a training does, beside the problem and the seed.
struct LearnerSettings {
  AgentKind kind = AgentKind::kMpdqn;
  AgentOptions agent;
  TrainingOptions training;
  DesignEnvironmentOptions environment;
};

/// Sets of settings that belong together.
enum class Preset {
  kReport,      ///< the protocol of the report's text, on the rewards and the observation of its environment
  kReportCode,  ///< the settings of its published code, its faults included
  kBest,        ///< ours
};
/// "report", "report-code", "best".
[[nodiscard]] std::string_view name(Preset preset);
[[nodiscard]] std::optional<Preset> preset_from_name(std::string_view name);
/// What goes with the sort of problem in `preset best`: one target, or sampled ones; obstacles or none.
struct ProblemTraits {
  bool sampled = false;
  bool obstacles = false;
  std::vector<double> goal_box{};  ///< sampled: EncoderOptions::goal_box
};
[[nodiscard]] ProblemTraits traits_of(const ProblemFile& file);
[[nodiscard]] LearnerSettings settings_of(AgentKind kind, Preset preset, const ProblemTraits& traits = {});

/// One setting, by its name: for command lines, records and policy files.
struct Setting {
  std::string key;
  std::string meaning;  ///< with unit and choices
  std::function<std::string(const LearnerSettings&)> get;
  /// Throws std::invalid_argument (key, text, limit) for text that is no such value.
  std::function<void(LearnerSettings&, const std::string&)> set;
};
/// All of them, in the order in which they are listed.
[[nodiscard]] const std::vector<Setting>& setting_table();
/// Throws std::invalid_argument for an unknown key (naming the known ones) or a bad value.
void apply_setting(LearnerSettings& settings, const std::string& key, const std::string& value);

}  // namespace modsearch
