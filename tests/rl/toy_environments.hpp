#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <modsearch/rl/environment.hpp>

namespace modsearch::testing {

/// One step: the state names the right action k* (one-hot) and its right parameter x*; the reward is 1 - |x_k - x*| for
/// k*, else 0. Whoever cannot learn this can learn nothing (the idea is Stable-Baselines3's).
class IdentityEnvironment final : public Environment {
 public:
  [[nodiscard]] std::string name() const override { return "identity"; }
  [[nodiscard]] const HybridSpace& space() const override { return space_; }
  [[nodiscard]] int observation_size() const override { return 4; }
  [[nodiscard]] std::unique_ptr<Environment> clone() const override { return std::make_unique<IdentityEnvironment>(); }

 private:
  View do_reset(Rng rng) override {
    k_ = rng.index(3);
    x_ = static_cast<float>(rng.uniform(-0.8, 0.8));
    return view();
  }
  Step do_step(int k, std::span<const float> x_k, View& next) override {
    next = view();
    const double reward = k == k_ ? 1.0 - std::abs(x_k[0] - x_) : 0.0;
    return {.reward = reward, .terminated = true, .truncated = false, .success = reward > 0.8};
  }
  [[nodiscard]] View view() const {
    Eigen::VectorXf s = Eigen::VectorXf::Zero(4);
    s[k_] = 1.0F;
    s[3] = x_;
    return {s, space_.all()};
  }

  HybridSpace space_{{1, 1, 1}};
  int k_ = 0;
  float x_ = 0.0F;
};

/// A corridor of length 1: "walk" (parameter: how far, up to 0.3 towards the end) until the end is reached, which pays
/// 1; every step costs 0.1. "stay" costs as much. The best return is 1 - 4 * 0.1. A door at 0.5 forbids "stay" beyond
/// it, so that masks matter. At most ten steps.
class CorridorEnvironment final : public Environment {
 public:
  [[nodiscard]] std::string name() const override { return "corridor"; }
  [[nodiscard]] const HybridSpace& space() const override { return space_; }
  [[nodiscard]] int observation_size() const override { return 1; }
  [[nodiscard]] std::unique_ptr<Environment> clone() const override { return std::make_unique<CorridorEnvironment>(); }

 private:
  View do_reset(Rng) override {
    place_ = 0.0F;
    steps_ = 0;
    return view();
  }
  Step do_step(int k, std::span<const float> x_k, View& next) override {
    if (k == 1) place_ = std::max(0.0F, place_ + 0.3F * x_k[0]);
    ++steps_;
    next = view();
    const bool there = place_ >= 1.0F;
    return {.reward = there ? 0.9 : -0.1, .terminated = there, .truncated = !there && steps_ == 10, .success = there};
  }
  [[nodiscard]] View view() const {
    return {Eigen::VectorXf::Constant(1, 2.0F * place_ - 1.0F), place_ < 0.5F ? ActionMask{3} : ActionMask{2}};
  }

  HybridSpace space_{{0, 1}};
  float place_ = 0.0F;
  int steps_ = 0;
};

}  // namespace modsearch::testing
