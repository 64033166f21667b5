#pragma once

#include <cstdint>
#include <memory>
#include <modsearch/rl/design_environment.hpp>
#include <optional>
#include <span>
#include <string>

#include "one_at_a_time.hpp"

namespace modsearch::python {

/// What Gymnasium hears of a step, beside observation and mask.
struct Outcome {
  double reward = 0.0;
  bool terminated = false;
  bool truncated = false;
  bool masked = false;    ///< the type was not allowed: the design stayed as it was
  bool failed = false;    ///< the problem could not evaluate the design
  std::string failure{};  ///< and what it had to say
  /// Of the design so far; nothing before the first module and after a failed evaluation.
  std::optional<double> score{};
  bool achieved = false;
};

/// Episodes of a design environment as Gymnasium wants them: a masked action is no error, an episode that has no room
/// for another module is terminated, and one that goes on for too long is truncated.
class Episodes {
 public:
  /// Observations beyond this are clipped: Gymnasium's spaces have ends. Twenty metres, where arms have a few.
  static constexpr float kBound = 10.0F;

  /// `max_steps`: an episode is truncated after so many, masked ones included; at least 2, for a first step that is cut
  /// off teaches nothing. Throws what DesignEnvironment throws.
  Episodes(ProblemSource source, DesignEnvironmentOptions options, int max_steps);
  Episodes(const Episodes&) = delete;  // its environment evaluates through it
  Episodes& operator=(const Episodes&) = delete;

  [[nodiscard]] const DesignEnvironment& environment() const { return environment_; }
  [[nodiscard]] const HybridSpace& space() const { return environment_.space(); }
  [[nodiscard]] int observation_size() const { return environment_.observation_size(); }
  [[nodiscard]] int max_steps() const { return max_steps_; }

  /// All episodes from now on are a function of `seed` and of their number.
  void seed(std::uint64_t seed);
  /// Begins the next episode.
  void reset();
  /// Begins an episode with this problem; the ones after it are drawn as before.
  void reset_to(const ProblemSource& source);
  /// Takes action `k` with `x_k`, whose first n_k numbers count. Throws std::logic_error outside an episode,
  /// std::invalid_argument for a k that is no action and for numbers that are NaN.
  Outcome step(int k, std::span<const float> x_k);

  /// Writes the observation [observation_size].
  void observe(float* out) const;
  /// Types that may follow the design, also where its episode was cut off; none before the first.
  [[nodiscard]] ActionMask mask() const { return environment_.mask(); }
  [[nodiscard]] bool running() const { return running_; }

 private:
  void begin(std::uint64_t seed);

  OneAtATime door_;
  ProblemSource source_;
  DesignEnvironment environment_;
  int max_steps_;
  Rng rng_{0};
  std::uint64_t episode_ = 0;
  int steps_ = 0;
  bool running_ = false;
  std::string failure_;  // what the last evaluation threw; empty: nothing
  HybridAction action_;  // used again and again
};

}  // namespace modsearch::python
