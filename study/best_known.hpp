#pragma once

#include <filesystem>
#include <modsearch/problem/files.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace modsearch {

/// The best design that anybody has found for one instance of a problem, and how it was found.
struct BestKnown {
  Instance instance;  ///< 0:0 of a problem that is not sampled
  double score = 0.0;
  Design design;
  Eigen::MatrixXd postures;  ///< at the goals, for evaluations to try first [n_goals x n_joints], rad or m
  std::string solver;
  std::vector<std::pair<std::string, std::string>> solver_options{};
  std::uint64_t seed = 0;
  std::int64_t evaluations = 0;  ///< that the search took
  double seconds = 0.0;
};

/// What regret counts from where no bound closes: the best known designs of one family. Every one is achieved and
/// verified by a collision-free path; none is proved to be the best there is.
struct BestKnownTable {
  std::string family;                ///< ID of a built-in problem: "whitman/3g_3o"
  std::vector<BestKnown> entries{};  ///< by rising instance

  /// Null where none is known.
  [[nodiscard]] const BestKnown* find(const Instance& instance) const;
};

/// Where the table of `family` lies: DIR/whitman/3g_3o.json.
[[nodiscard]] std::filesystem::path best_known_file(const std::filesystem::path& folder, const std::string& family);
/// Reads a table; checks its form and not its designs. Throws FileError.
[[nodiscard]] BestKnownTable load_best_known(const std::filesystem::path& file);
/// The table as text, the inverse of load_best_known.
[[nodiscard]] std::string best_known_to_json(const BestKnownTable& table);

/// What merging did to one table.
struct BestKnownCounts {
  std::string family;
  int added = 0;     ///< instances that had no design
  int improved = 0;  ///< instances whose design scored less
  int kept = 0;      ///< designs that score no more than the known one
};
struct BestKnownMerge {
  std::vector<BestKnownCounts> counts{};         ///< by family
  std::vector<std::string> refused{};            ///< one sentence for each design that does not verify
  std::vector<std::filesystem::path> written{};  ///< tables that have changed
};

/// Verifies the designs in `files` (solution files, as `solve` writes them, and tables) with their postures: achieved,
/// as good as they say, by a path that is free when looked at finer. What is better than the table in `folder` knows
/// takes its place there; tables are written at the end, each whole or not at all, and only where they have changed.
/// Throws FileError for a file that cannot be used; then nothing is written.
[[nodiscard]] BestKnownMerge merge_best_known(const std::filesystem::path& folder,
                                              std::span<const std::filesystem::path> files);

}  // namespace modsearch
