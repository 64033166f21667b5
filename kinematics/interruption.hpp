#pragma once

#include <functional>

namespace modsearch {

/// What a computation ends with that was asked to stop in its middle. No std::exception on purpose: who catches those
/// takes them for a failure of the thing that was computed, and this says nothing about it.
struct Interrupted {};

/// While it lives, long computations of this thread (inverse kinematics, plans, distances) ask `stop` every few dozen
/// microseconds and end with Interrupted where it says yes. Computations that are not interrupted are not changed by it
/// in any bit. Scopes may be nested: each of them can stop what is within it.
class Interruptible {
 public:
  explicit Interruptible(std::function<bool()> stop);
  ~Interruptible();
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

 private:
  friend void interruption_point();

  std::function<bool()> stop_;
  Interruptible* outer_;
};

/// Throws Interrupted where a scope of this thread says so; a nanosecond where there is none. For the loops that make
/// computations long.
void interruption_point();

}  // namespace modsearch
