#pragma once

#include <modsearch/rl/action_values.hpp>
#include <modsearch/rl/adam.hpp>
#include <modsearch/rl/agent.hpp>
#include <modsearch/rl/agent_options.hpp>

namespace modsearch {

/// Values that learn: Q, its slowly following target Q', and what the learning remembers; of each two where the options
/// ask for TD3's twins (Fujimoto et al. 2018, section 4.2). PA-DDPG's critic is the case of one action, whose parameters
/// are the preferences and parameters of all.
class LearningValues {
 public:
  /// Throws std::invalid_argument as make_action_values() does.
  LearningValues(ValueKind kind, const HybridSpace& space, int observation_size, const AgentOptions& options, Rng rng);

  /// The one that acts and that an actor climbs.
  [[nodiscard]] ActionValues& q() { return *critics_.front().q; }
  /// Q'(s, x) [B x K], the smaller of the twins.
  [[nodiscard]] RowMatrixXf target(const RowMatrixXf& s, const RowMatrixXf& x);
  /// One step of Adam down L = mean_B (Q(s, x)_k - y)^2, which `facts` gets with its gradient's norm.
  void fit(const RowMatrixXf& s, const RowMatrixXf& x, const Eigen::VectorXi& k, const Eigen::VectorXf& y, double rate,
           UpdateFacts& facts);
  /// The targets follow.
  void follow();
  /// Adds its memory to `parts`. `acts`: the policy needs q().
  void append_state(std::vector<StatePart>& parts, bool acts);

 private:
  struct Critic {
    std::unique_ptr<ActionValues> q;
    std::unique_ptr<ActionValues> q_target;
    Adam adam;
    Eigen::VectorXf gradient;
  };

  float tau_;
  std::vector<Critic> critics_;  // one, or two of TD3
};

}  // namespace modsearch
