#pragma once

#include <modsearch/baselines/certify/tree_text_internal.hpp>

namespace modsearch::certify {

/// How a search has cut its boxes and closed some of them, in the words of a certificate: the tree grows wherever a
/// box is open, and is written down in the end. A place of it is a box; the first is the box of everything.
class TreeRecord {
 public:
  static constexpr std::size_t kRoot = 0;

  void halve(int variable) { entries_[kRoot].text.halve(variable); }
  void cut_off(std::size_t place, const std::vector<CutOff>& cuts) { entries_[place].text.cut_off(cuts); }
  void close(std::size_t place, const ClosedLeaf& leaf);
  /// The place of the lower half; that of the upper one is the next.
  std::size_t split(std::size_t place, int variable, double at);

  /// Goes through the tree in preorder, from one open place to the next; the record must outlive it.
  class Walk {
   public:
    explicit Walk(const TreeRecord& record) : record_{&record} {}
    /// Appends to `text` what comes before the next open place, and stops there; false: there is no other.
    [[nodiscard]] bool next(TreeText& text);
    /// The open place where it has stopped.
    [[nodiscard]] std::size_t place() const { return place_; }

   private:
    const TreeRecord* record_;
    std::vector<std::size_t> pending_{kRoot};
    std::size_t place_ = kRoot;
  };

 private:
  struct Entry {
    TreeText text;           // parts that are cut off, the leaf or the split
    std::size_t halves = 0;  // place of the lower one; 0: not split
    bool closed = false;
  };
  std::vector<Entry> entries_{1};
};

}  // namespace modsearch::certify
