#include <modsearch/baselines/certify/tree_record_internal.hpp>

namespace modsearch::certify {

void TreeRecord::close(std::size_t place, const ClosedLeaf& leaf) {
  entries_[place].text.close(leaf);
  entries_[place].closed = true;
}

std::size_t TreeRecord::split(std::size_t place, int variable, double at) {
  const std::size_t halves = entries_.size();
  entries_[place].text.split(variable, at);
  entries_[place].halves = halves;
  entries_.resize(halves + 2);
  return halves;
}

bool TreeRecord::Walk::next(TreeText& text) {
  while (!pending_.empty()) {
    place_ = pending_.back();
    pending_.pop_back();
    const Entry& entry = record_->entries_[place_];
    text.append(entry.text);
    if (entry.halves > 0) {
      pending_.push_back(entry.halves + 1);
      pending_.push_back(entry.halves);
    } else if (!entry.closed) {
      return true;
    }
  }
  return false;
}

}  // namespace modsearch::certify
