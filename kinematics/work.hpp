#pragma once

#include <cstdint>

namespace modsearch {

/// Inner work behind an evaluation, counted by whoever does it and summed by the meter.
struct Work {
  std::int64_t forward = 0;         ///< forward kinematics
  std::int64_t ik_iterations = 0;   ///< steps of inverse kinematics
  std::int64_t distances = 0;       ///< shape pairs whose separation or overlap was asked for
  std::int64_t planner_states = 0;  ///< states a planner or a path check looked at

  Work& operator+=(const Work& other) {
    forward += other.forward;
    ik_iterations += other.ik_iterations;
    distances += other.distances;
    planner_states += other.planner_states;
    return *this;
  }
};

}  // namespace modsearch
