#pragma once

#include <array>
#include <modsearch/problem/rng.hpp>
#include <string_view>

namespace modsearch {

/// What the player of Platform can do.
enum class PlatformAction {
  kRun,   ///< for 20 sub-steps; parameter: speed gained per sub-step, [0, 30] px/s
  kHop,   ///< high jump; parameter: distance aimed at, [0, 720] px
  kLeap,  ///< low jump; parameter: distance aimed at, [0, 430] px
};

/// How an action of Platform ended.
struct PlatformOutcome {
  int sub_steps = 0;     ///< of 0.05 s
  double reward = 0.0;   ///< distance gained / length of the world
  bool arrived = false;  ///< at the right end of the world
  bool fallen = false;   ///< into a gap
  bool touched = false;  ///< an enemy

  [[nodiscard]] bool over() const { return arrived || fallen || touched; }
};

/// The physics of Platform (Masson et al. 2016, "Reinforcement learning with parameterized actions", AAAI): a player
/// runs and jumps over three platforms with two gaps, and past an enemy on each of the first two. Lengths in pixels,
/// lower left corners, y upwards; speeds in px/s.
///
/// The constants are those of the published benchmark, the odd ones included: a jump adds at most 30 px/s whatever its
/// parameter, so that distance needs a run before; the enemies' first move is against their bound; only the enemy of
/// the player's side moves.
class PlatformWorld {
 public:
  static constexpr double kLength = 1035.0;  ///< right end of the world [px]
  static constexpr int kStateSize = 9;

  /// Largest parameter of an action; the smallest is 0.
  [[nodiscard]] static double largest(PlatformAction action);

  struct Body {
    double x = 0.0;   ///< [px]
    double y = 40.0;  ///< [px]
    double vx = 0.0;  ///< [px/s]
    double vy = 0.0;  ///< [px/s]
  };

  /// The start of an episode. `noise` scales all noise: 1 as published, 0 for none.
  explicit PlatformWorld(Rng rng, double noise = 1.0);

  /// Takes an action with its parameter in px or px/s, clipped to [0, largest(action)].
  /// Throws std::invalid_argument if it is NaN, std::logic_error after the end.
  PlatformOutcome act(PlatformAction action, double parameter);

  [[nodiscard]] const Body& player() const { return player_; }
  /// The enemy of platform 0 or 1.
  [[nodiscard]] const Body& enemy(int platform) const { return enemies_.at(static_cast<std::size_t>(platform)); }
  /// Standing on a platform: not in the air, not past an edge.
  [[nodiscard]] bool grounded() const;
  /// x, vx, x and vx of the enemy that moves, width of this platform and the next, the gap between them, start of this
  /// platform, difference in height; each shifted and scaled into [0, 1] as published.
  [[nodiscard]] std::array<double, kStateSize> scaled_state() const;

 private:
  /// Acts, or falls where there is no ground; moves everything once.
  void sub_step(PlatformAction action, double parameter, PlatformOutcome& outcome);
  void push_off(PlatformAction action, double parameter);
  void accelerate(double ax, double ay);
  void move_enemy();
  void leave_platforms();
  [[nodiscard]] int active_enemy() const;
  /// |N(0, deviation^2)|
  double lost(double deviation);

  Rng rng_;
  double noise_;
  Body player_;
  std::array<Body, 2> enemies_;
  bool over_ = false;
};

}  // namespace modsearch
