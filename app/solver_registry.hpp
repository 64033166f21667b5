#pragma once

#include <functional>
#include <map>
#include <memory>
#include <modsearch/solvers/solver.hpp>
#include <string>
#include <utility>
#include <vector>

namespace modsearch::app {

/// One option of a solver, as `list solvers` shows it.
struct OptionEntry {
  std::string key;
  std::string default_value;
  std::string meaning;  ///< with unit and choices
};

using OptionValues = std::map<std::string, std::string>;

/// A solver that the command line knows.
struct SolverEntry {
  std::string name;
  std::string meaning;
  std::vector<OptionEntry> options;
  std::function<std::unique_ptr<Solver>(const OptionValues&)> make;
};

/// All of them, in the order in which they are listed.
[[nodiscard]] const std::vector<SolverEntry>& solver_entries();

/// A solver as it was asked for.
struct ChosenSolver {
  std::unique_ptr<Solver> solver;
  std::string name;
  std::vector<std::pair<std::string, std::string>> options;  ///< as given
};

/// From "name", "name:key=value,key=value" or "policy:FILE".
/// Throws std::invalid_argument (what is unknown, what is known) for anything else, FileError
/// for a policy that cannot be used.
[[nodiscard]] ChosenSolver choose_solver(const std::string& text);

}  // namespace modsearch::app
