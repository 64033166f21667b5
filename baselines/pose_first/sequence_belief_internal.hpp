#pragma once

#include <modsearch/baselines/pose_first/sequence_sampler_internal.hpp>
#include <modsearch/problem/design_problem.hpp>
#include <modsearch/solvers/archive.hpp>
#include <optional>
#include <vector>

namespace modsearch::detail {

/// What a search believes of the type sequences of a problem: how likely the poses are met, by stratum and by pairs of
/// neighbours, what a sequence may score at most, and how much work a try is. It orders what is tried and excludes
/// nothing.
class SequenceBelief {
 public:
  /// `problem` must outlive it and have pose programs.
  SequenceBelief(const DesignProblem& problem, Rng rng);

  struct Drawn {
    std::vector<int> types;
    Stratum stratum;
    double bound = 0.0;  ///< no achieved design with these types scores more
  };
  /// A sequence that could score more than `to_beat`: of a stratum drawn by what it promises (chance of a success times
  /// what it could gain over `to_beat`, for its work), by the weights of its pairs. Nothing: none was met in a number
  /// of draws.
  [[nodiscard]] std::optional<Drawn> draw(double to_beat, Rng& rng);
  /// A try of `types` took `work` and was a success of `success` in [0, 1].
  void learn(std::span<const int> types, double success, double work);

  /// The greatest bound of all sequences met so far.
  [[nodiscard]] double greatest_bound() const;
  [[nodiscard]] const SequenceSampler& sampler() const { return sampler_; }

  void save(Archive& archive) const;
  void restore(const Archive& archive);

 private:
  struct Experience {
    Stratum stratum;
    double bound = 0.0;  // greatest one met
    double prior = 0.0;  // chance of a success before anything was tried
    double tried = 0.0;
    double succeeded = 0.0;
    double work = 0.0;  // of all tries
  };
  [[nodiscard]] double chance(const Experience& experience) const;
  [[nodiscard]] std::size_t choose(double to_beat, Rng& rng) const;
  void weigh_by_cost(Rng& rng);
  void weigh_pairs();
  [[nodiscard]] std::size_t pair(int previous, int type) const;

  const DesignProblem& problem_;
  SequenceSampler sampler_;
  std::vector<Experience> strata_;
  std::vector<double> cheapness_;  // [n_types] weight of a type by what it costs
  std::vector<double> met_;        // [pairs] successes of tries that held the pair
  std::vector<double> expected_;   // [pairs] successes that their strata made one expect
  int learned_ = 0;                // tries since the weights were set
};

}  // namespace modsearch::detail
