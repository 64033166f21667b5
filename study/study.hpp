#pragma once

#include <functional>
#include <memory>
#include <modsearch/problem/problem_source.hpp>
#include <modsearch/rl/settings.hpp>
#include <modsearch/solvers/solver.hpp>
#include <modsearch/study/records.hpp>
#include <optional>
#include <string>
#include <vector>

namespace modsearch {

/// Instances of a sampled problem: numbers `first` .. `first` + `count` - 1 of seed `seed`. The same for every solver.
struct InstanceRange {
  std::uint64_t seed = 1;  ///< people who try things use instance 0:0; trainings draw from all 64-bit numbers
  std::uint64_t first = 0;
  int count = 15;  ///< the least for a family (docs/comparing.md)
};

/// A problem to solve, or a family of them.
struct StudyProblem {
  std::string name;                           ///< file, ID, or any name for one of your own
  std::optional<InstanceRange> instances{};   ///< of a family; none: there is one problem
  /// Instance by its name; without `instances` it is asked for 0:0. Called once for every cell.
  std::function<std::shared_ptr<const DesignProblem>(Instance)> make;
  std::string location{};  ///< ID or file from which a page can load it; empty: nowhere
  std::string content{};   ///< what else decides what it is, such as the text of its file: goes into the study's hash
};
/// A built-in problem or a file. `instances` as in StudyProblem; without it a sampled problem gives one instance, 1:0.
/// Throws FileError, and std::invalid_argument for instances of a problem that is not sampled.
[[nodiscard]] StudyProblem study_problem(const std::string& file_or_id,
                                         std::optional<InstanceRange> instances = std::nullopt);

/// How a policy comes about: one training per seed, each a cell of its own.
struct StudyTraining {
  std::string problem;  ///< name of the family it is trained on; a run on a problem of this name uses it
  ProblemSource source;
  std::shared_ptr<const ModuleLibrary> library;
  LearnerSettings settings;               ///< its final episodes are left out: runs say more
  std::string preset{};                   ///< from which the settings were made, for the policy's file
  std::vector<std::uint64_t> seeds{0};    ///< the i-th seed of the study uses the policy of seeds[i mod n]
};

/// A solver to compare.
struct StudySolver {
  std::string label;  ///< in tables
  std::string text;   ///< name and options: "ga:polish=3"; decides, with the rest, which cell it is
  std::shared_ptr<const Solver> solver{};  ///< null where it is a policy that the study trains
  /// A policy's: on problems that none of them is trained on, the first one's policy is used.
  std::vector<StudyTraining> trainings{};
  /// Lets the smooth program of the found type sequence follow (Refined); the budget is that of both.
  bool refine = false;
};

/// How the best possible score of each instance is bounded: by a solver that gives bounds.
struct StudyCertification {
  std::string text;  ///< its name and options
  std::shared_ptr<const Solver> solver;
  Budget budget{.evaluations = 1'000'000, .seconds = 30.0};  ///< per instance
};

/// A comparison: solvers x problems x instances x seeds, all with one budget.
struct Study {
  std::string name;
  std::vector<StudyProblem> problems;
  std::vector<StudySolver> solvers;
  std::vector<std::uint64_t> seeds{0};  ///< of the runs; the same for every solver (paired)
  Budget budget{};                      ///< of one run
  /// Targets of runtimes beside feasibility and the least number of modules: mass within these shares of the bound [%].
  std::vector<double> mass_targets{50.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.1};
  std::optional<StudyCertification> certification{};
};

/// A cell with where it finds what it computes. Indices into the study's lists and into its cells.
struct PlannedCell {
  CellRecord record;  ///< ID, number and key
  std::size_t problem = 0;
  std::size_t solver = 0;             ///< not of a bound
  std::size_t training = 0;           ///< of a training: which of the solver's
  std::optional<std::size_t> needs{};  ///< the training that has to come first
};

/// 16 hexadecimal digits: the FNV-1a hash of everything in the key but the label, so that a cell has the same ID in
/// every study.
[[nodiscard]] std::string cell_id(const CellKey& key);
/// All cells in order: trainings, bounds, then runs by problem, instance, solver and seed.
/// Throws std::invalid_argument (what, value) for a study without problems, solvers or seeds, for names that are empty
/// or occur twice, for two cells that are the same, and for parts that are missing.
[[nodiscard]] std::vector<PlannedCell> cells_of(const Study& study);
/// What a journal says of `study` at its beginning. `command`: for people who want to do it again.
[[nodiscard]] StudyFacts facts_of(const Study& study, const std::string& command = {});

}  // namespace modsearch
