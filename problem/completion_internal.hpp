#pragma once

#include <limits>
#include <map>
#include <modsearch/problem/module_library.hpp>
#include <span>
#include <vector>

namespace modsearch::detail {

/// Which types may follow when a design must still be able to end in an end effector: a sequence that has no room for
/// one any more is never achieved, and a search that builds it has wasted all that it spends there.
///
/// Worked out once for a library: for each kind of free end the least number of modules to an end effector, by
/// relaxation until nothing changes, as in Bellman and Ford's shortest paths. A walk along a sequence then is one look
/// into a table per module.
class Completion {
 public:
  explicit Completion(const ModuleLibrary& library);

  /// Types that fit the free end of base + `types` and after which `room` - 1 more modules or fewer make the design
  /// complete, in rising order. A library without end effectors is complete anywhere.
  /// Throws std::invalid_argument if `types` do not fit in turn.
  [[nodiscard]] std::vector<int> successors(std::span<const int> types, int room) const;

 private:
  static constexpr int kNever = std::numeric_limits<int>::max();
  using Coupling = ModuleLibrary::Coupling;
  struct Step {
    int type = 0;
    int next = 0;          // free end after it
    int modules = kNever;  // it and those after it until the design is complete, at least
  };
  [[nodiscard]] int number_of(const Coupling& coupling);
  [[nodiscard]] int after(int end, int k) const;

  const ModuleLibrary& library_;
  std::map<Coupling, int> numbers_;       // of the free ends that occur
  std::vector<Coupling> ends_;            // by number, 0: that of the base
  std::vector<std::vector<Step>> steps_;  // [n_ends], types that fit in rising order
};

}  // namespace modsearch::detail
