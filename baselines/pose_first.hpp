#pragma once

#include <modsearch/solvers/search.hpp>

namespace modsearch {

struct PoseFirstOptions {
  /// Of the pose program, each time that a sequence is tried. Measured on six tasks of `whitman/3g_3o`, seed 7, five
  /// seconds each: 16, 32 and 64 end at 52.4, 52.3 and 53.7 in the median.
  int starts = 64;
  int iterations = 25;  ///< of the smooth program that makes room for bodies and takes off mass
};

/// Poses first, clearance when needed: for tasks of several full poses among obstacles.
///
/// Type sequences are drawn from a model that learns which of them meet poses; all goals' poses and the lengths are
/// solved for at once from many starts (the problem's pose program); what arrives is looked at for bodies that overlap
/// and joints that are too weak, and only there the smooth program makes room; what is free is evaluated with the
/// postures that were found. What has been found is improved: modules removed, put in, exchanged, with the lengths
/// solved for again from the old ones.
///
/// Best-first in this sense: what is drawn next is what promises most, the estimated chance of a success times what it
/// could gain by its upper bound, for the work it takes. The estimates order and never exclude: a sequence is closed by
/// its bound alone, and one whose starts failed stays open. (Counting degrees of freedom, and a heuristic that is
/// learned: Whitman, Bhirangi, Travers and Choset 2020, "Modular Robot Design Synthesis with Deep Reinforcement
/// Learning", AAAI, doi:10.1609/aaai.v34i06.6611; distributions over sequences that follow what succeeds: estimation of
/// distribution algorithms, Larrañaga and Lozano 2002.)
///
/// Anytime: it goes on until the meter says stop, and ends by itself only where no bound is above the best.
class PoseFirst final : public SteppedSolver {
 public:
  /// Throws std::invalid_argument for less than one start or iteration.
  explicit PoseFirst(PoseFirstOptions options = {});
  /// Whether the problem has pose programs for its sequences.
  [[nodiscard]] static bool covers(const DesignProblem& problem);
  [[nodiscard]] std::string name() const override { return "pose-first"; }
  [[nodiscard]] const PoseFirstOptions& options() const { return options_; }
  /// On a problem that is not covered the search ends with the empty design and says so.
  [[nodiscard]] std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const override;

 private:
  PoseFirstOptions options_;
};

}  // namespace modsearch
