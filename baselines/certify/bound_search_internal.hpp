#pragma once

#include <modsearch/baselines/certify/sequence_tree_internal.hpp>
#include <modsearch/baselines/certify/witness_internal.hpp>
#include <modsearch/baselines/sequence_frontier.hpp>
#include <modsearch/solvers/inner_solver.hpp>
#include <modsearch/solvers/search.hpp>

namespace modsearch::certify {

/// Best-first branch and bound over all type sequences and all their lengths and postures at once.
class BoundSearch final : public Search {
 public:
  /// `problem`, which is covered (why_not_covered), must outlive it.
  /// `most_boxes`: ends after so many expansions; 0: no limit.
  BoundSearch(const RobotProblem& problem, double gap, std::int64_t most_boxes = 0);

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
  /// The box that holds the bound up, in words.
  [[nodiscard]] std::string what_is_open() const;

 private:
  struct Sequence {
    std::vector<int> types;
    double head = 0.0;                   // score of no mass
    std::unique_ptr<SequenceTree> tree;  // null: too large to be searched
    std::unique_ptr<SmoothProgram> program;
    std::int64_t next_solve = 0;  // expansions after which to look for a design again
  };

  // Points that are closed: what scores no more need not be looked at.
  [[nodiscard]] double closing_score() const;
  [[nodiscard]] double cut(const Sequence& sequence) const;
  [[nodiscard]] double score_bound(const Sequence& sequence) const;
  [[nodiscard]] double open_bound() const;
  void add(std::vector<int> types, double bound, Meter& meter);
  void look_for_design(Sequence& sequence, const Eigen::VectorXd& start, bool weak, Meter& meter);
  void consider(const Design& design, const Eigen::MatrixXd& postures);
  [[nodiscard]] SearchEnd end(const Meter& meter) const;

  const RobotProblem& problem_;
  double gap_ = 0.0;
  std::int64_t most_boxes_ = 0;
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
