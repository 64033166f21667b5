#pragma once

#include <memory>
#include <modsearch/problem/files.hpp>
#include <optional>
#include <string>

namespace modsearch::app {

/// A problem with the instance of it that was asked for.
struct ChosenProblem {
  ProblemFile file;
  std::optional<Instance> instance;  ///< of a sampled problem
  std::shared_ptr<const RobotProblem> problem;
};

/// Reads a problem and draws the instance (0:0 by default). Throws std::invalid_argument and FileError.
[[nodiscard]] ChosenProblem choose_problem(const std::string& name, const std::optional<Instance>& asked,
                                           const FileOptions& options);

}  // namespace modsearch::app
