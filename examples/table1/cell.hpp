#pragma once

#include <modsearch/problem/files.hpp>
#include <modsearch/rl/settings.hpp>
#include <modsearch/rl/training.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "table1/fallible_reach.hpp"

namespace table1 {

/// One training: a cell of the table.
struct CellRequest {
  std::string row;  ///< under which name the table collects it
  std::string problem = "seed/fixed";
  modsearch::AgentKind agent = modsearch::AgentKind::kMpdqn;
  modsearch::Preset preset = modsearch::Preset::kReport;
  std::uint64_t seed = 0;
  std::optional<double> tolerance;  ///< of the goal [m], instead of the problem's own
  std::optional<FallibleIk> ik;     ///< instead of the exact inverse kinematics
  std::vector<std::string> types;   ///< the library's types that may be chosen; all where empty
  std::vector<std::pair<std::string, std::string>> settings;  ///< of the agent, in place of the preset's
};

/// What came of it.
struct CellResult {
  std::string row;
  std::string agent;
  std::uint64_t seed = 0;
  std::string end;  ///< of the training
  std::int64_t episodes = 0;
  std::optional<std::int64_t> stabilised_after;  ///< episodes until ten evaluations in a row are all one-step
  std::optional<std::int64_t> first_one_step{};  ///< episodes until one is
  std::int64_t one_step_evaluations = 0;         ///< how many are
  double best_return = 0.0;                      ///< of an evaluation
  double final_return = 0.0;
  double final_deviation = 0.0;
  double final_one_step = 0.0;  ///< share of the final episodes that end in one step
  std::string design{};         ///< the greedy one at the end, of the first final episode's problem
  std::string types{};          ///< of its modules
  double exact_score = 0.0;     ///< of `design`, in the problem as it is: exact inverse kinematics, its own tolerance
  bool exact_reached = false;
  double seconds = 0.0;  ///< of training, wall clock
  double seconds_per_1000 = 0.0;
};

/// The problems that a request trains in.
[[nodiscard]] modsearch::ProblemSource source_of(const CellRequest& request);
/// Its settings. Throws std::invalid_argument for an unknown one.
[[nodiscard]] modsearch::LearnerSettings settings_of(const CellRequest& request);

/// Trains. `history` gets the evaluations.
[[nodiscard]] CellResult run_cell(const CellRequest& request, std::vector<modsearch::EvaluationPoint>& history);

/// First line of a file of results, and one of its rows.
[[nodiscard]] std::string csv_columns();
[[nodiscard]] std::string csv_row(const CellResult& result);
/// Reads such a file. Throws std::runtime_error (file, line) for anything else.
[[nodiscard]] std::vector<CellResult> load_cells(const std::string& file);

}  // namespace table1
