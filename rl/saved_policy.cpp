#include <fmt/format.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/rl/saved_policy.hpp>
#include <stdexcept>

namespace modsearch {

PolicyFile describe(const Policy& policy, const ModuleLibrary& library, const std::string& problem,
                    PolicyFile::Facts training) {
  PolicyFile file;
  file.agent = name(policy.settings().kind);
  for (const Setting& setting : setting_table()) file.settings.emplace(setting.key, setting.get(policy.settings()));
  file.observation_size = policy.observation_size();
  for (int k = 0; k < library.n_types(); ++k) {
    file.actions.push_back({library.type(k).id, library.type(k).n_parameters()});
  }
  file.problem = problem;
  file.library = library.name();
  file.training = std::move(training);
  file.tensors = policy.tensors();
  return file;
}

std::unique_ptr<Policy> revive(const PolicyFile& file) {
  const std::optional<AgentKind> kind = agent_kind_from_name(file.agent);
  if (!kind) throw std::invalid_argument(fmt::format("/agent: '{}' is no agent of this version", file.agent));
  LearnerSettings settings;
  settings.kind = *kind;
  for (const auto& [key, value] : file.settings) apply_setting(settings, key, value);
  return std::make_unique<Policy>(std::move(settings), file.space(), file.observation_size, file.tensors);
}

std::unique_ptr<Policy> load_trained_policy(const std::filesystem::path& file) {
  const PolicyFile loaded = load_policy(file);
  try {
    return revive(loaded);
  } catch (const std::invalid_argument& e) {
    throw FileError(fmt::format("{}: {}", file.string(), e.what()));
  }
}

}  // namespace modsearch
