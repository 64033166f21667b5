#pragma once

// What the arms of a library must contain to be complete. Internal to the problem floor.

#include <modsearch/problem/module_library.hpp>
#include <modsearch/problem/reach_bound.hpp>
#include <span>
#include <vector>

namespace modsearch::detail {

/// Lightest, cheapest and longest ways to complete an arm by a given number of modules: dynamic programming over its
/// free end, because what may follow depends on nothing else. Each is the best of its kind, and may be another
/// completion.
class Completions {
 public:
  /// `spans`: of the types [n_types]. `may_end`: whether a complete arm may end with a type [n_types]. `least_joints`:
  /// an arm needs at least so many, those of the base included.
  Completions(const ModuleLibrary& library, std::span<const ModuleSpan> spans, const std::vector<bool>& may_end,
              int least_joints, int most_modules);

  /// Of arms that begin with `types`, by `more` modules. Those that have too few joints, that do not fit or that may
  /// not end so are not among them; `possible` is false where no other is left.
  [[nodiscard]] Continuation completion(std::span<const int> types, int more) const;

 private:
  struct Type {
    std::vector<int> next;  // free end after it, by the free end before it [n_ends]; -1: does not fit
    int joints = 0;
  };
  [[nodiscard]] Continuation& entry(int more, int end, int missing) {
    return table_[static_cast<std::size_t>((more * n_ends_ + end) * (least_joints_ + 1) + missing)];
  }
  [[nodiscard]] const Continuation& entry(int more, int end, int missing) const {
    return table_[static_cast<std::size_t>((more * n_ends_ + end) * (least_joints_ + 1) + missing)];
  }

  std::vector<Type> types_;
  std::vector<bool> may_end_;
  int base_joints_ = 0;
  int least_joints_ = 0;
  int n_ends_ = 0;
  int most_modules_ = 0;
  std::vector<Continuation> table_;  // [more][end][missing joints]
};

}  // namespace modsearch::detail
