#include "platform/platform_world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr double kTimeStep = 0.05;  // [s]
constexpr double kGravity = 9.8;
constexpr double kTop = 40.0;  // of all platforms
constexpr double kWidth = 20.0;
constexpr double kHeight = 30.0;  // of player and enemies alike
constexpr int kRunSubSteps = 20;

constexpr double kMostAcceleration[] = {600.0, 4000.0};
constexpr double kMostSpeed[] = {100.0, 200.0};
constexpr double kMostGroundSpeed = 70.0;
constexpr double kDrag = 0.99;  // of vx, per sub-step
constexpr double kEnemySpeed = 30.0;
constexpr double kSpeedNoise = 0.025;  // of player and enemies, per sub-step
constexpr double kJumpNoise = 1.0;
constexpr double kHopSpeed = 35.0;  // upwards, at first
constexpr double kLeapSpeed = 25.0;

struct Platform {
  double start;
  double width;
  [[nodiscard]] double end() const { return start + width; }
};
constexpr std::array<Platform, 3> kPlatforms = {{{0.0, 250.0}, {475.0, 275.0}, {985.0, 50.0}}};

/// Overlapping bodies share an area; those that only touch do not.
bool overlap(const PlatformWorld::Body& a, const PlatformWorld::Body& b) {
  return std::abs(a.x - b.x) < kWidth && std::abs(a.y - b.y) < kHeight;
}

}  // namespace

double PlatformWorld::largest(PlatformAction action) {
  switch (action) {
    case PlatformAction::kRun:
      return 30.0;
    case PlatformAction::kHop:
      return 720.0;
    case PlatformAction::kLeap:
      return 430.0;
  }
  throw std::invalid_argument("Platform: no such action");
}

PlatformWorld::PlatformWorld(Rng rng, double noise) : rng_{rng}, noise_{noise} {
  for (std::size_t i = 0; i < enemies_.size(); ++i) {
    enemies_[i] = {.x = kPlatforms[i].end() - kWidth, .y = kTop, .vx = -kEnemySpeed};
  }
}

PlatformOutcome PlatformWorld::act(PlatformAction action, double parameter) {
  if (over_) throw std::logic_error("Platform: an action after the end of the episode");
  if (std::isnan(parameter)) throw std::invalid_argument("Platform: the parameter of an action is NaN");
  parameter = std::clamp(parameter, 0.0, largest(action));
  const double start = player_.x;
  PlatformOutcome outcome;
  // A run takes its time; a jump lasts until there is ground again.
  const auto finished = [&] { return action == PlatformAction::kRun ? outcome.sub_steps == kRunSubSteps : grounded(); };
  do {
    sub_step(action, parameter, outcome);
  } while (!outcome.over() && !finished());
  over_ = outcome.over();
  outcome.reward = (player_.x - start) / kLength;
  return outcome;
}

void PlatformWorld::sub_step(PlatformAction action, double parameter, PlatformOutcome& outcome) {
  ++outcome.sub_steps;
  if (grounded()) {
    push_off(action, parameter);
    player_.vx = std::clamp(player_.vx, 0.0, kMostGroundSpeed);
  } else {
    accelerate(0.0, -kGravity);
  }
  player_.x = std::clamp(player_.x + player_.vx * kTimeStep, 0.0, kLength);
  player_.y += player_.vy * kTimeStep;
  player_.vx *= kDrag;
  move_enemy();
  leave_platforms();

  outcome.arrived = player_.x >= kLength;
  outcome.fallen = !outcome.arrived && player_.y < kTop;
  outcome.touched = !outcome.arrived && std::any_of(enemies_.begin(), enemies_.end(),
                                                    [&](const Body& enemy) { return overlap(player_, enemy); });
}

void PlatformWorld::push_off(PlatformAction action, double parameter) {
  if (action == PlatformAction::kRun) return accelerate(parameter / kTimeStep, 0.0);
  const double up = action == PlatformAction::kHop ? kHopSpeed : kLeapSpeed;
  const double flight = 2.0 * up / kGravity + 1.0;  // [s], one more than until the ground
  const double forward = std::clamp(parameter / flight - player_.vx, -600.0, 200.0 - up);
  const double forward_lost = lost(kJumpNoise);
  const double up_lost = lost(kJumpNoise);
  accelerate((forward - forward_lost) / kTimeStep, (up - up_lost) / kTimeStep);
}

void PlatformWorld::accelerate(double ax, double ay) {
  ax = std::clamp(ax, -kMostAcceleration[0], kMostAcceleration[0]);
  ay = std::clamp(ay, -kMostAcceleration[1], kMostAcceleration[1]);
  // Never backwards.
  player_.vx = std::clamp(player_.vx + ax * kTimeStep - lost(kSpeedNoise), 0.0, kMostSpeed[0]);
  player_.vy = std::clamp(player_.vy + ay * kTimeStep, -kMostSpeed[1], kMostSpeed[1]);
}

void PlatformWorld::move_enemy() {
  const auto i = static_cast<std::size_t>(active_enemy());
  Body& enemy = enemies_[i];
  const double left = kPlatforms[i].start;
  const double right = kPlatforms[i].end() - kWidth;
  if (enemy.x <= left || enemy.x >= right) enemy.vx = -enemy.vx;
  enemy.vx = std::clamp(enemy.vx + noise_ * kSpeedNoise * rng_.normal(), -kEnemySpeed, kEnemySpeed);
  enemy.x = std::clamp(enemy.x + enemy.vx * kTimeStep, left, right);
}

void PlatformWorld::leave_platforms() {
  for (const Platform& platform : kPlatforms) {
    const double from_left = player_.x + kWidth - platform.start;
    const double from_right = platform.end() - player_.x;
    const double from_above = kTop - player_.y;
    if (from_left <= 0.0 || from_right <= 0.0 || from_above <= 0.0) continue;
    if (from_above <= std::min(from_left, from_right)) {
      player_.y = kTop;  // landed
      player_.vy = 0.0;
    } else {
      player_.x += from_left < from_right ? -from_left : from_right;
    }
    player_.vx = 0.0;
  }
}

bool PlatformWorld::grounded() const {
  return player_.y == kTop && std::any_of(kPlatforms.begin(), kPlatforms.end(), [&](const Platform& platform) {
           return -kWidth <= player_.x - platform.start && player_.x <= platform.end();
         });
}

int PlatformWorld::active_enemy() const { return player_.x > kPlatforms[1].start ? 1 : 0; }

std::array<double, PlatformWorld::kStateSize> PlatformWorld::scaled_state() const {
  constexpr std::array<double, kStateSize> kShift = {20.0, 0.0, 0.0, 30.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  constexpr std::array<double, kStateSize> kScale = {1055.0, 100.0, 1035.0, 60.0, 275.0, 275.0, 235.0, 1035.0, 1.0};
  const std::size_t here = player_.x < kPlatforms[1].start ? 0 : player_.x < kPlatforms[2].start ? 1 : 2;
  const Platform& platform = kPlatforms[here];
  const bool last = here + 1 == kPlatforms.size();
  const double next_width = last ? 0.0 : kPlatforms[here + 1].width;
  const double gap = last ? 0.0 : kPlatforms[here + 1].start - platform.end();
  const Body& enemy = enemies_[static_cast<std::size_t>(active_enemy())];
  std::array<double, kStateSize> state = {player_.x,  player_.vx, enemy.x,        enemy.vx, platform.width,
                                          next_width, gap,        platform.start, 0.0};
  for (std::size_t i = 0; i < state.size(); ++i) state[i] = (state[i] + kShift[i]) / kScale[i];
  return state;
}

double PlatformWorld::lost(double deviation) { return std::abs(noise_ * deviation * rng_.normal()); }

}  // namespace modsearch
