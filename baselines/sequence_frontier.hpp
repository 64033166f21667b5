#pragma once

#include <cstddef>
#include <modsearch/solvers/archive.hpp>
#include <modsearch/solvers/meter.hpp>
#include <optional>
#include <string>
#include <vector>

namespace modsearch {

/// The type sequences of a problem in falling order of their optimism (modules, mass by reach), best-first: what is
/// kept are prefixes with a number of modules to grow to, and each is worth the bound of the best that it can grow
/// into. Only what could still win is ever built. Ties: fewer modules first, then longer prefixes, then the order of
/// types.
class SequenceFrontier {
 public:
  /// `limit`: prefixes kept at once. Where there are more, the best is followed to its end depth first before the next,
  /// which costs the strict order and keeps memory bounded. A million take some 100 MB.
  /// `weights`: designs that each type stands for, see `left_out`.
  explicit SequenceFrontier(const DesignProblem& problem, std::size_t limit = 1'000'000,
                            std::vector<double> weights = {});

  struct Sequence {
    std::vector<int> types;
    double bound = 0.0;  ///< no achieved design with these types scores more
  };
  /// The next sequence whose bound is above score_to_beat(meter). Nothing: none is left (`exhausted`), or the work of
  /// one call is done (some milliseconds): call again.
  [[nodiscard]] std::optional<Sequence> next(const Meter& meter);
  [[nodiscard]] bool exhausted() const { return heap_.empty() && dive_.empty(); }
  /// No achieved design of what is still to come scores more; -inf: nothing is.
  [[nodiscard]] double bound() const;
  /// Why sequences were left out although nothing beats them, the last reason; empty: none was.
  [[nodiscard]] const std::string& impossible() const { return impossible_; }
  /// How many complete designs were left out for that, type k standing for weights[k] of them; 0 without weights.
  [[nodiscard]] double left_out() const { return left_out_; }

  void save(Archive& archive) const;
  void restore(const Archive& archive);

 private:
  struct Node {
    double bound = 0.0;
    int length = 0;            // modules of the sequences that this grows into
    std::vector<int> types{};  // so far
  };
  [[nodiscard]] static bool comes_later(const Node& a, const Node& b);
  [[nodiscard]] Node take();
  void expand(const Node& node, bool diving);
  // Keeps the node if a design can come of it.
  void offer(Node node, Optimism optimism, std::vector<Node>& to);

  const DesignProblem& problem_;
  std::size_t limit_;
  std::vector<Node> heap_;
  std::vector<Node> dive_;  // worked off first, the last one first
  std::string impossible_;
  std::vector<double> weights_;  // [n_types] or none
  double left_out_ = 0.0;
};

}  // namespace modsearch
