#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace modsearch {

/// Batches and weights of networks: one row per sample, so that a row is contiguous.
using RowMatrixXf = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Which discrete actions are allowed: bit k for action k. At most 64 actions.
using ActionMask = std::uint64_t;

/// A hybrid (parameterised) action space (Masson et al. 2016, "Reinforcement learning with parameterized actions"): K
/// discrete actions, action k with n_k continuous parameters of its own, each scaled to [-1, 1]; D of them in total,
/// x = (x_1 .. x_K).
class HybridSpace {
 public:
  static constexpr int kMaxActions = 64;

  /// `parameters_per_action`: n_k for k = 0 .. K - 1.
  /// Throws std::invalid_argument unless 1 <= K <= 64 and every n_k >= 0.
  explicit HybridSpace(std::vector<int> parameters_per_action);

  [[nodiscard]] int n_actions() const { return static_cast<int>(counts_.size()); }         ///< K
  [[nodiscard]] int n_parameters() const { return offsets_.back(); }                       ///< D
  [[nodiscard]] int count(int k) const { return counts_[static_cast<std::size_t>(k)]; }    ///< n_k
  [[nodiscard]] int offset(int k) const { return offsets_[static_cast<std::size_t>(k)]; }  ///< where x_k begins in x
  /// All actions.
  [[nodiscard]] ActionMask all() const;

  friend bool operator==(const HybridSpace&, const HybridSpace&) = default;

 private:
  std::vector<int> counts_;   // [K]
  std::vector<int> offsets_;  // [K + 1]
};

/// An action as an agent takes it: k with its x_k, and the parameters of all the others beside it, because the value
/// networks of P-DQN see them all.
struct HybridAction {
  int k = 0;
  Eigen::VectorXf x;            ///< [D], each in [-1, 1]
  Eigen::VectorXf preferences;  ///< [K], by which PA-DDPG chose k; empty for other agents
};

}  // namespace modsearch
