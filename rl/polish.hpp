#pragma once

#include <modsearch/rl/action_model.hpp>

namespace modsearch {

struct PolishOptions {
  /// Steps aim at this share of the tolerance: inside by enough that what a linear step leaves over does not lead out
  /// again.
  double aim = 0.5;
  /// Goes on to the lightest parameters within reach instead of the nearest.
  bool descend_mass = false;
  /// descend_mass: how close to the edge of the tolerance it lands. The rest is 0.5 um for a tolerance of 1 mm: a few
  /// times the rounding of lengths in single precision, and worth 2.5e-6 points.
  double edge = 0.9995;
};

/// Moves the parameters x_k of action k, scaled to [-1, 1], in place towards parameters that reach: at most `steps`
/// Gauss-Newton steps on the model's error, each the shortest that the linearised error asks for within the box. Stops
/// as soon as the error is within the tolerance. Returns the steps used; 0 where the model has no answer.
///
/// With `descend_mass` every step solves a small linear program: the least mass such that the linearised error is
/// within the tolerance, parameters in the box (a fractional knapsack, solved greedily). What it returns reaches if any
/// look on the way did, and is then the lightest of those.
int polish(const ActionModel& model, int k, std::span<float> x_k, int steps, const PolishOptions& options, Work& work);

}  // namespace modsearch
