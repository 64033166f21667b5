#pragma once

#include <functional>
#include <modsearch/study/study.hpp>
#include <string>
#include <vector>

namespace modsearch {

/// What the texts of a study file stand for. Both throw std::invalid_argument (what is unknown, what is known).
struct StudyNames {
  struct NamedSolver {
    std::string text;  ///< name and options in one fixed order
    std::shared_ptr<const Solver> solver;
  };
  struct NamedAgent {
    std::string text;
    std::string preset;
    LearnerSettings settings;
  };
  /// "ga:polish=3", ..
  std::function<NamedSolver(const std::string& text)> solver;
  /// "mpdqn:preset=best", .. for training on a problem.
  std::function<NamedAgent(const std::string& text, const ProblemFile& problem)> agent;
};

/// Reads a study file (docs/comparing.md), or a built-in one by its ID ("quick"). Problem files are named relative to
/// it. Throws FileError (file, JSON pointer, value, limit).
[[nodiscard]] Study load_study(const std::string& file_or_id, const StudyNames& names);

/// IDs of the built-in studies, sorted.
[[nodiscard]] std::vector<std::string> builtin_studies();

}  // namespace modsearch
