#pragma once

#include <modsearch/rl/replay.hpp>

namespace modsearch {

/// How rewards become targets.
struct ReturnOptions {
  double reward_scale = 1.0;      ///< rewards are stored times this; 0.1 suits scores of hundreds
  int steps = 1;                  ///< rewards summed before the value of a later state takes over (n-step returns)
  bool remaining = false;         ///< the whole discounted return is wanted too (mixed targets)
  bool legacy_terminals = false;  ///< ends of episodes are not stored, as in the published PA-DDPG: to study that fault
  bool truncation_ends = false;   ///< a cut-off counts as an end, as in the reference: to reproduce it
};

/// Turns the transitions of an episode into experiences: from a state whose episode has terminated nothing follows,
/// nor from one in which nothing may be done any more; from one that was cut off otherwise the value still does (Pardo
/// et al. 2018, "Time limits in reinforcement learning").
class Returns {
 public:
  /// Throws std::invalid_argument unless steps >= 1 and gamma in [0, 1].
  Returns(ReturnOptions options, double gamma);

  /// Experiences that are complete once `transition` is known, in order of time: at once for one-step returns, else at
  /// the end of the episode.
  [[nodiscard]] std::vector<Experience> add(const Agent& agent, Transition transition);

 private:
  [[nodiscard]] double discount_after(const Transition& last, int steps) const;

  ReturnOptions options_;
  double gamma_;
  std::vector<Transition> episode_;
};

}  // namespace modsearch
