#pragma once

#include <limits>
#include <modsearch/baselines/certify/sequence_tree_internal.hpp>
#include <modsearch/baselines/certify/witness_internal.hpp>
#include <modsearch/baselines/sequence_frontier.hpp>
#include <modsearch/solvers/inner_solver.hpp>
#include <modsearch/solvers/search.hpp>

namespace modsearch::certify {

struct BoundSearchOptions {
  double gap = 1e-4;            ///< see BranchAndBoundOptions
  std::int64_t most_boxes = 0;  ///< ends after so many expansions; 0: no limit
  bool recorded = false;        ///< keeps the trees for a certificate
  /// Designs that score no more are not looked for.
  double floor = -std::numeric_limits<double>::infinity();
};

/// Best-first branch and bound over all type sequences and all their lengths and postures at once.
class BoundSearch final : public Search {
 public:
  /// `problem`, which is covered (why_not_covered), must outlive it.
  BoundSearch(const RobotProblem& problem, const BoundSearchOptions& options);

  [[nodiscard]] std::optional<SearchEnd> step(Meter& meter) override;
  void save(Archive& archive) const override;
  void restore(const Archive& archive) override;

  /// The lightest design of the best score that reaches with some posture within the tolerance, if one was found.
  [[nodiscard]] const std::optional<Witness>& best_witness() const { return witness_; }
  /// No achieved design scores more; -inf: none is achieved.
  [[nodiscard]] double upper(const Meter& meter) const;
  /// Nothing is open any more above the witness and its gap.
  [[nodiscard]] bool closed() const { return closed_; }
  [[nodiscard]] std::int64_t expanded() const;
  /// Boxes that are open.
  [[nodiscard]] std::int64_t n_open() const;
  /// What is known of a sequence, if it is recorded; null: it was not looked at.
  [[nodiscard]] SequenceTree* tree(std::span<const int> types);
  /// The box that holds the bound up, in words.
  [[nodiscard]] std::string what_is_open() const;

 private:
  struct Sequence {
    std::vector<int> types;
    double head = 0.0;                       // score of no mass
    std::unique_ptr<SequenceTree> tree;      // null: too large to be searched, or given up
    std::unique_ptr<SequenceTree> given_up;  // recorded, with a box that cannot be cut
    std::unique_ptr<SmoothProgram> program;
    std::int64_t next_solve = 0;  // expansions after which to look for a design again
  };

  // What the best design scores and this share of the gap.
  [[nodiscard]] double score_at(double share) const;
  // Points that are closed: the search is over when nothing scores more.
  [[nodiscard]] double closing_score() const { return score_at(1.0); }
  [[nodiscard]] double cut(const Sequence& sequence) const;
  [[nodiscard]] double score_bound(const Sequence& sequence) const;
  [[nodiscard]] double open_bound() const;
  void add(std::vector<int> types, double bound, Meter& meter);
  void look_for_design(Sequence& sequence, const Eigen::VectorXd& start, bool weak, Meter& meter);
  void consider(const Design& design, const Eigen::MatrixXd& postures);
  [[nodiscard]] SearchEnd end(const Meter& meter) const;

  const RobotProblem& problem_;
  BoundSearchOptions options_;
  double weight_ = 0.0;  // points per kilogram
  Scenery scenery_;
  SequenceFrontier frontier_;
  std::vector<Sequence> sequences_;
  std::optional<Witness> witness_;
  double stuck_;  // greatest bound of what cannot be cut any more
  bool begun_ = false;
  bool closed_ = false;
};

}  // namespace modsearch::certify
