#pragma once

#include <modsearch/baselines/certify/proof_tree_internal.hpp>
#include <modsearch/baselines/certify/tree_record_internal.hpp>
#include <modsearch/solvers/archive.hpp>

namespace modsearch::certify {

/// The open boxes of one type sequence, best-first: branch and bound on the least mass that achieves the task.
class SequenceTree {
 public:
  /// `scenery` must outlive it. `model.fits()` is taken for granted. `recorded`: keeps what proof() needs.
  SequenceTree(const RobotProblem& problem, const Scenery& scenery, std::span<const int> types, bool recorded = false);

  [[nodiscard]] const SequenceModel& model() const { return *model_; }
  [[nodiscard]] bool exhausted() const { return nodes_.empty(); }
  /// No achieved design in the open boxes weighs less [kg]; +inf: there are none.
  [[nodiscard]] double least_mass() const;
  [[nodiscard]] std::int64_t expanded() const { return expanded_; }
  [[nodiscard]] std::size_t n_open() const { return nodes_.size(); }

  /// Deals with the box of everything. `cut`: what weighs at least this is not wanted [kg].
  void open(double cut);
  /// Cuts the box with the least bound in two. False: it is too small to be cut any more.
  [[nodiscard]] bool expand(double cut);
  /// The middle of that box [n_variables]: parameters, then joints goal by goal.
  [[nodiscard]] Eigen::VectorXd middle() const;
  /// That box, in words: for studies of what does not close.
  [[nodiscard]] std::string description() const;

  /// What was cut off and closed so far as the tree of a certificate; the boxes that are open are closed against `cut`,
  /// which is at most that of any call before. A tree that is recorded and was not restored.
  [[nodiscard]] ProofOutcome proof(double cut, const std::function<bool()>& stop);

  void save(Archive& archive, const std::string& name) const;
  void restore(const Archive& archive, const std::string& name);

 private:
  struct Node {
    double bound = 0.0;
    std::int64_t number = 0;
    int split = -1;
    double at = 0.0;
    Box box;
    Multipliers multipliers;
    std::size_t place = TreeRecord::kRoot;  // in the record
  };
  [[nodiscard]] static bool comes_later(const Node& a, const Node& b);
  void offer(Box box, Multipliers multipliers, double bound, double cut, std::size_t place);

  int n_goals_ = 0;
  std::unique_ptr<SequenceModel> model_;
  std::unique_ptr<NodeProver> prover_;
  std::vector<Node> nodes_;  // a heap
  std::optional<TreeRecord> record_;
  std::int64_t numbered_ = 0;
  std::int64_t expanded_ = 0;
};

}  // namespace modsearch::certify
