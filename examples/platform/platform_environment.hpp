#pragma once

#include <modsearch/rl/environment.hpp>
#include <optional>

#include "platform/platform_world.hpp"

namespace modsearch {

/// Platform as a hybrid-action environment: the published benchmark for agents like those of this library (Masson et
/// al. 2016; scaled as Bester et al. 2019 do). Reward of an action: distance gained / length, so that the return of an
/// episode is how far the player came, 1 at the right end. Falling, touching an enemy and arriving terminate an
/// episode; the limit of 200 actions truncates it.
///
/// Observation [9]: PlatformWorld::scaled_state() mapped on to [-1, 1]. Actions: run, hop, leap, one parameter each, -1
/// for 0 and 1 for the largest.
class PlatformEnvironment final : public Environment {
 public:
  struct Options {
    int most_actions = 200;  ///< per episode; the published limit
    double noise = 1.0;      ///< scale of all noise; 1 as published
  };

  /// Throws std::invalid_argument unless most_actions >= 1 and noise >= 0.
  explicit PlatformEnvironment(Options options);
  PlatformEnvironment() : PlatformEnvironment(Options{}) {}

  [[nodiscard]] std::string name() const override { return "platform"; }
  [[nodiscard]] const HybridSpace& space() const override { return space_; }
  [[nodiscard]] int observation_size() const override { return PlatformWorld::kStateSize; }
  [[nodiscard]] std::unique_ptr<Environment> clone() const override;

  /// The physics behind the current episode. Throws std::logic_error before the first reset.
  [[nodiscard]] const PlatformWorld& world() const;

 private:
  View do_reset(Rng rng) override;
  Step do_step(int k, std::span<const float> x_k, View& next) override;
  [[nodiscard]] View view() const;

  Options options_;
  HybridSpace space_{{1, 1, 1}};
  std::optional<PlatformWorld> world_;
  int actions_ = 0;
};

}  // namespace modsearch
