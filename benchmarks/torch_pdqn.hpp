#pragma once

#include <memory>
#include <modsearch/rl/action_values.hpp>
#include <modsearch/rl/agent.hpp>
#include <modsearch/rl/agent_options.hpp>
#include <string>

namespace modsearch {

/// The library behind LibTorch's matrix products: OpenBLAS makes its update more than twice as fast as ATLAS does.
[[nodiscard]] std::string torch_blas();

/// P-DQN and MP-DQN in LibTorch with autograd, as its users write them: the reference of rl_benchmark.
class TorchPdqn {
 public:
  /// Starts at the weights of `agent` (a P-DQN or MP-DQN with `options`). `in_double`: as the exact answer, not for
  /// speed.
  TorchPdqn(ValueKind kind, Agent& agent, const AgentOptions& options, bool in_double);
  ~TorchPdqn();

  /// The batch that update() learns from, converted once.
  void set_batch(const Batch& batch);
  void update();
  /// Greedy action at s [observation_size].
  [[nodiscard]] int act(const Eigen::VectorXf& s) const;
  /// Largest difference of any weight to those of `agent`.
  [[nodiscard]] double difference(Agent& agent) const;

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

}  // namespace modsearch
