#pragma once

#include <compare>
#include <map>
#include <modsearch/problem/module_library.hpp>
#include <modsearch/problem/rng.hpp>
#include <vector>

namespace modsearch::detail {

/// Joints of the module that move.
[[nodiscard]] int moving_joints(const ModuleType& type);

/// All type sequences with so many modules and so many joints that move.
struct Stratum {
  int modules = 0;
  int joints = 0;
  friend auto operator<=>(const Stratum&, const Stratum&) = default;
};

/// Draws complete type sequences of a stratum, each as likely as the product of the weights of its pairs of neighbours:
/// nothing is drawn and thrown away. What may follow depends on the last module and its free end alone, so that a table
/// of sums over (modules left, joints left, free end) is all it takes.
class SequenceSampler {
 public:
  /// `most_modules`: of a sequence, at least 0. `library` must outlive it.
  SequenceSampler(const ModuleLibrary& library, int most_modules);

  /// Those that hold any sequence, in rising order.
  [[nodiscard]] const std::vector<Stratum>& strata() const { return strata_; }
  /// Joints that move of each type.
  [[nodiscard]] int joints_of(int type) const { return joints_[static_cast<std::size_t>(type)]; }
  [[nodiscard]] int joints_in(std::span<const int> types) const;

  /// The weight of `type` right behind `previous` (-1: the base); 1 at first, and at least 0.
  void set_weight(int previous, int type, double weight);
  [[nodiscard]] double weight(int previous, int type) const;
  /// Takes the weights into account; to be called after they were set.
  void refresh();

  /// A sequence of `stratum`, which has to be one of strata(). Empty if the weights leave none.
  [[nodiscard]] std::vector<int> draw(Stratum stratum, Rng& rng) const;

 private:
  // A free end behind a module.
  struct End {
    int type = -1;  // of the module; -1: the base
    ModuleLibrary::Coupling coupling;
    bool complete = false;                            // nothing is missing
    std::vector<std::pair<int, std::size_t>> next{};  // type that may follow, and the end that it leaves
  };
  std::size_t find_or_add(int type, const ModuleLibrary::Coupling& coupling);
  [[nodiscard]] double& sum(int modules, int joints, std::size_t end);
  [[nodiscard]] double sum(int modules, int joints, std::size_t end) const;

  const ModuleLibrary& library_;
  int most_modules_;
  int most_joints_;
  std::vector<int> joints_;      // [n_types]
  std::vector<End> ends_;        // the first is that of the base
  std::vector<double> weights_;  // [(n_types + 1) x n_types]
  std::vector<double> sums_;     // [modules left][joints left][end]
  std::vector<Stratum> strata_;
};

}  // namespace modsearch::detail
