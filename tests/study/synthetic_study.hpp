#pragma once

#include <modsearch/study/records.hpp>

namespace modsearch::testing {

/// What a made-up study looks like.
struct SyntheticOptions {
  int instances = 15;  ///< of each of the two families
  int seeds = 10;
  bool bounds = true;  ///< of the first family: certified at the least mass
};

/// A study that nobody ran, whose truth is known. Families "seed/random_narrow" and "seed/random_wide"; the least mass
/// of instance i is 1.6 + 0.02 i kg with two modules. Solvers: "steady" halves its excess mass whenever evaluations
/// double; "slow" takes eight times as long and fails on the last instance of each family; "agent" is trained with
/// 20 000 evaluations in 40 s and has 3 % excess after its second evaluation, which is its last.
/// One run of "slow" has crashed and one has not ended.
[[nodiscard]] StudyRecord synthetic_study(const SyntheticOptions& options = {});

}  // namespace modsearch::testing
