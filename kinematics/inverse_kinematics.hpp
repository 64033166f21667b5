#pragma once

#include <cstdint>
#include <modsearch/kinematics/arm.hpp>
#include <modsearch/kinematics/pose_region.hpp>
#include <vector>

namespace modsearch {

struct IkOptions {
  /// Starts of the local search for chains of more than three joints (and for regions other than balls): a fixed
  /// low-discrepancy set over the joint limits. Its size is part of the definition of "reachable" there (PROBLEM 3).
  int starts = 32;
  /// Steps of one local search at most.
  int iterations = 64;
  /// Postures whose error is within this of the least one count as equally close [m]; at most 1e-8 (PROBLEM 3: 1e-9).
  double tie = 1e-9;
  /// One-parameter families of equally close postures are given at about this many points, families of more parameters
  /// on a coarse grid of a few times as many.
  int family_points = 256;
  /// All equally close postures are wanted; false: one is enough, which is much cheaper.
  bool all = true;
  /// Two joints about one line can share a turn in a family of ways. false: one way is enough, because what stands between
  /// them looks alike from all sides. At most three joints and a ball; otherwise ignored.
  bool shared_turns = true;
};

/// Postures that bring the tip as close to a region as the arm can.
struct IkSolution {
  bool reached = false;  ///< the region contains the tip at `postures`
  bool exact = false;    ///< the verdict and `position_error` are exact, not those of a finite set of starts
  /// Distance of the tip from the nominal position at the best posture [m].
  double position_error = 0.0;
  /// Norm of the violations at the best posture, in the projections' own units; 0 when reached.
  double violation = 0.0;
  /// Equally close postures [n_joints] within the limits, in a fixed order; at least one, and the first is the one that
  /// the numbers above speak of. Isolated ones are distinct up to whole turns of full-circle joints; a sample of a
  /// family may repeat one of them.
  std::vector<Eigen::VectorXd> postures;
  std::int64_t iterations = 0;  ///< steps of local searches, and forward kinematics
  std::int64_t forward = 0;
};

/// Inverse kinematics with joint limits: the posture(s) with the tip closest to the region.
///
/// "Closest" means the least distance of the tip from the nominal position for a ball, the least norm of the violations
/// otherwise. Balls and at most three joints: the global minimum, by closed forms where the arm has them (every arm of
/// the `seed` library), else by Pieper's quartic, a grid and Newton's method; `all` then gives every posture that
/// attains it, families sampled. Otherwise a fixed low-discrepancy set of starts (at most three joints: a dense grid as
/// well), each refined by a projected Levenberg-Marquardt method; with `all` false the first that is reached ends it.
/// The method, what "exact" rests on, and measurements: docs/inverse_kinematics.md.
///
/// A function of its arguments: no random numbers, no clock, equal bits from any thread.
/// Throws std::invalid_argument if starts, iterations or family_points is below 1, or tie not in [0, 1e-8].
[[nodiscard]] IkSolution inverse_kinematics(const Arm& arm, const PoseRegion& region, const IkOptions& options = {});

}  // namespace modsearch
