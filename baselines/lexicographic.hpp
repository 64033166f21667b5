#pragma once

#include <cstdint>
#include <limits>
#include <modsearch/solvers/archive.hpp>
#include <modsearch/solvers/solver.hpp>
#include <optional>
#include <string>

namespace modsearch {

/// How far a design comes, for methods that compare designs with one another: level by level from cheap to dear, then
/// by what is measured within the level, then by score (lexicographic fitness: Külz and Althoff 2024, "Optimizing
/// Modular Robot Composition: A Lexicographic Genetic Algorithm Approach", ICRA, arXiv:2309.08399).
///
/// The score alone would mislead: before a target is reached, a metre of arm costs five points and a metre of distance
/// less than one, so that the fittest of those that miss is the shortest. Here it is the one that misses least.
struct Rank {
  enum class Level {
    kHopeless,    ///< by the bound of its types it is not achieved, or no better than the best so far: never evaluated
    kFailed,      ///< its evaluation threw or gave NaN
    kIncomplete,  ///< lacks an end effector
    kMisses,      ///< does not reach every goal; within: how far it misses
    kCollides,    ///< reaches every goal in collision; within: how deep
    kNoPath,      ///< the goals' postures are free, the way there is not
    kAchieved,
  };
  Level level = Level::kHopeless;
  double within = 0.0;  ///< greater is better
  double score = -std::numeric_limits<double>::infinity();

  /// Greater is better.
  friend auto operator<=>(const Rank&, const Rank&) = default;
};

/// The rank that a checkpoint holds as these numbers. Throws FileError, naming `entry`, for a level that there is not
/// and for what is not a number: ranks are sorted by.
[[nodiscard]] Rank restored_rank(const Archive& archive, const std::string& entry, std::int64_t level, double within,
                                 double score);

[[nodiscard]] Rank rank(const Evaluation& evaluation);

/// The rank of `design`, with no more effort than it is worth: bound of its types, then the screen, then the full
/// evaluation if the screen could beat the best so far. Nothing when the meter says stop.
[[nodiscard]] std::optional<Rank> evaluate_rank(Meter& meter, const DesignProblem& problem, const Design& design);

/// The best achieved score so far; -inf before the first.
[[nodiscard]] double score_to_beat(const Meter& meter);

/// An upper bound in so many digits, for people: never less than the bound itself.
[[nodiscard]] std::string rounded_up(double bound, int digits = 6);

/// Nothing better is left of a design that was evaluated so: it is achieved, or proved not to be.
[[nodiscard]] bool is_settled(const Evaluation& evaluation);
/// Why evaluations prove nothing, in words: how many ended with searches that gave up.
[[nodiscard]] std::string nothing_proved(const Meter& meter);

/// How a search ends that the problem's bounds make pointless: nothing can be attached, no design is achieved, or none
/// can beat the best. Nothing: there is a point.
[[nodiscard]] std::optional<SearchEnd> pointless(const Meter& meter, const DesignProblem& problem);

}  // namespace modsearch
