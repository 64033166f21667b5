#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <modsearch/baselines/lexicographic.hpp>
#include <modsearch/solvers/archive.hpp>
#include <vector>

namespace modsearch {

/// Ranks as values in [0, 1]: a part of the interval for each level, and within it by how far the design comes, then by
/// score between the least and the greatest that the level has seen.
class ValueScale {
 public:
  void see(const Rank& rank);
  [[nodiscard]] double value(const Rank& rank) const;

  void save(Archive& archive) const;
  void restore(const Archive& archive);

 private:
  static constexpr std::size_t kLevels = static_cast<std::size_t>(Rank::Level::kAchieved) + 1;
  struct Range {
    double least = std::numeric_limits<double>::infinity();
    double greatest = -std::numeric_limits<double>::infinity();
  };
  std::array<Range, kLevels> scores_;
};

/// The designs that a tree search has met, each hanging on its prefix.
class DesignTree {
 public:
  /// The modules of one type that may follow a design.
  struct Branch {
    int type = 0;
    double own_bound = 0.0;     // no achieved design that ends with this module scores more
    double deeper_bound = 0.0;  // nor one that goes on after it
    std::int64_t visits = 0;
    std::vector<int> children{};  // nodes
  };
  struct Node {
    int parent = -1;
    Placement placement;
    Rank own;   // of the design itself
    Rank best;  // of the design and all below it that were evaluated
    std::int64_t visits = 0;
    bool finished = false;  // nothing below can beat the best
    bool expanded = false;
    std::vector<Branch> branches{};
  };

  /// `problem` must outlive it. There is a root, the empty design.
  explicit DesignTree(const DesignProblem& problem);

  [[nodiscard]] Node& node(int i) { return nodes_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const Node& node(int i) const { return nodes_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] Design design(int i) const;
  /// Gives the node its branches, if it has none yet.
  void expand(int i);
  /// A new child of node `parent` in its branch number `b`.
  int add(int parent, std::size_t b, Placement placement);
  /// One more visit of the node and of all above it, with what was found there.
  void back_up(int i, const Rank& found);

  void save(Archive& archive) const;
  void restore(const Archive& archive);

 private:
  const DesignProblem& problem_;
  std::vector<Node> nodes_;  // parents before their children
};

}  // namespace modsearch
