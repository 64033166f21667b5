#pragma once

#include <modsearch/baselines/certify/ascent_internal.hpp>
#include <modsearch/baselines/certify/obstacle_rows_internal.hpp>

namespace modsearch::certify {

/// A box that holds no design worth having, and what shows it.
struct ClosedLeaf {
  Objective kind = Objective::kMass;
  Multipliers multipliers;
};

/// Parts of a box, each next to one end of a variable, that the same multipliers cut off.
struct CutOff {
  struct Part {
    int variable = 0;
    double at = 0.0;
    bool above = false;  ///< the part above `at`; else the part below
  };
  ClosedLeaf leaf;  ///< about the whole box
  std::vector<Part> parts;
};

/// What came of a box.
struct Verdict {
  bool closed = false;
  double bound = 0.0;  ///< no achieved design in what is left of it weighs less [kg]
  int split = -1;      ///< where to cut what is left; -1: nowhere
  double at = 0.0;
  ClosedLeaf leaf;  ///< where it is closed
};

/// Closes boxes of one sequence, or makes them smaller: multipliers by ascent from those of the box around, obstacle
/// rows among them, and parts cut off by concavity against the mass that is wanted or because nothing there reaches.
class NodeProver {
 public:
  NodeProver(const SequenceModel& model, const Scenery& scenery);

  /// `box` is cut down and `multipliers` are improved. `cut`: closed is what weighs at least this [kg]; +inf: what
  /// holds nothing achieved. Parts cut off are appended to `rounds`, if it is not null: those of one entry are all
  /// about the box that the entries before have left.
  [[nodiscard]] Verdict prove(Box& box, Multipliers& multipliers, double cut, std::vector<std::vector<CutOff>>* rounds);

  /// Multipliers to begin with: towards the goals.
  [[nodiscard]] Multipliers first_multipliers() const;

 private:
  [[nodiscard]] double target(const Box& box, double cut) const;
  // Fills in rows and multipliers of a box for `bound`; drops rows that do not hold there.
  void load(NodeBound& bound, const Box& box, const Multipliers& multipliers, std::vector<double>& values) const;
  void store(const std::vector<double>& values, bool cap, Multipliers& multipliers) const;
  // The leaf that closes the box by these multipliers, if they do.
  [[nodiscard]] bool closes(const Box& box, const Multipliers& multipliers, double cut, Objective objective,
                            ClosedLeaf& leaf);
  void write(const Multipliers& multipliers, Objective objective, ClosedLeaf& leaf) const;
  // Cuts off what the last value of `bound_` closes against `wanted`; the share of the box that is left.
  double contract(Box& box, const Multipliers& multipliers, double cut, double wanted, Objective objective,
                  std::vector<CutOff>* cuts);
  double contract_by_reach(Box& box, double cut, std::vector<CutOff>* cuts);
  // Where to cut the box; what all its widths cost together, at these multipliers [kg].
  double choose_split(const Box& box, const std::vector<double>& values, Verdict& verdict);
  void split_for_rows(const Box& box, bool hopeless, Verdict& verdict);

  const SequenceModel& model_;
  const Scenery& scenery_;
  NodeBound bound_;
  NodeBound written_bound_;  // as a certificate has it
  Ascent ascent_;
  std::vector<RowCandidate> candidates_;
  std::vector<double> values_, written_values_, losses_, shares_;
};

}  // namespace modsearch::certify
