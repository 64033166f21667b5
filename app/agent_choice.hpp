#pragma once

#include <modsearch/problem/files.hpp>
#include <modsearch/rl/settings.hpp>
#include <string>

namespace modsearch::app {

/// An agent as it was asked for.
struct ChosenAgent {
  std::string text;  ///< name and options, sorted by key: one text for what is one agent
  std::string preset;
  LearnerSettings settings;
};

/// From "name" or "name:key=value,key=value", for training on `problem`.
/// Throws std::invalid_argument (what is unknown, what is known) for anything else.
[[nodiscard]] ChosenAgent choose_agent(const std::string& text, const ProblemFile& problem);

}  // namespace modsearch::app
