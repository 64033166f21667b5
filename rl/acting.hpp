#pragma once

#include <modsearch/rl/agent.hpp>
#include <modsearch/rl/polish.hpp>

namespace modsearch {

/// What is done to a policy's proposal before it is carried out.
struct ActingOptions {
  int polish = 0;                   ///< most Gauss-Newton steps on the chosen module's parameters; 0: raw
  PolishOptions polishing{};          ///< how they are done
  int proposals = 1;                ///< polished proposals of which the best by its true reward is taken
  double proposal_deviation = 0.3;  ///< of the proposals about the policy's own, in scaled units (the range is 2)
  bool all_types = false;           ///< as many proposals for every allowed type, not only for the policy's
};

/// The action to carry out in the present state of `environment` instead of the policy's own `action`: polished, and
/// the best of several. What is stored for learning is the policy's own.
[[nodiscard]] HybridAction refined(const HybridAction& action, const Environment& environment,
                                   const ActingOptions& options, Rng& rng, Work& work);

}  // namespace modsearch
