#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <modsearch/kinematics/arm.hpp>
#include <modsearch/kinematics/pose_region.hpp>
#include <span>

namespace modsearch {

struct SimultaneousIkOptions {
  int iterations = 60;  ///< steps of one start at most: those that arrive take 10 to 40
  /// A radian of rotation counts as much as this many metres: about half an arm's forearm (arbitrary).
  double length = 0.25;
  /// A start is given up where a step after the tenth lowers the cost by less than this share of it (measured:
  /// docs/inverse_kinematics.md).
  double least_gain = 1e-2;
  /// Times that a start which is stuck with some goals met draws the postures of the others anew.
  int restarts = 8;
};

/// Inverse kinematics of all goals of a task at once, with the lengths of the arm among the unknowns: one set of
/// parameters x and a posture q_g for each goal g, so that the tip is in region g at (x, q_g). Arms with fewer than six
/// joints meet several full poses only in this way, because no lengths are right for them but a few.
///
/// Levenberg-Marquardt on the sum of squares (metres, and radians times `length`), within the bounds of x and the joint
/// limits, from many starts: eight at a time, one in each lane of a vector register. The normal equations have the
/// shape of an arrow (a block per goal, coupled by x alone) and are solved block by block. Bits do not depend on the
/// instruction set.
///
/// Regions whose tolerances speak of x, y, z, r_sph, r_cyl, N_x, N_y, N_z and Theta_R are covered, one frame for all of
/// the position and one for all of the rotation; intervals wider than a few millimetres or degrees cost nothing within.
///
/// A workspace too: one thread at a time.
class SimultaneousIk {
 public:
  /// Whether every tolerance of the region is one that can be aimed at.
  [[nodiscard]] static bool covers(const PoseRegion& region);

  /// `chain` must outlive it. `x_lower`, `x_upper` [n_parameters]: bounds of the parameters.
  /// Throws std::invalid_argument for no goals, a region that is not covered, or bounds of another size.
  SimultaneousIk(const Chain& chain, std::span<const PoseRegion> goals, const Eigen::VectorXd& x_lower,
                 const Eigen::VectorXd& x_upper, const SimultaneousIkOptions& options = {});
  ~SimultaneousIk();
  SimultaneousIk(SimultaneousIk&&) noexcept;
  SimultaneousIk& operator=(SimultaneousIk&&) noexcept;

  /// Variables v = (x, q_0, q_1, ..) [n_parameters + n_goals * n_joints] and their bounds; a full turn about 0 stands
  /// for the limits of a joint that turns all round.
  [[nodiscard]] const Eigen::VectorXd& lower() const;
  [[nodiscard]] const Eigen::VectorXd& upper() const;

  /// Whether the goals can be followed in general: at a point within the bounds, a fixed one, every change of what the
  /// goals ask for is met by a change of v (the Jacobian of the equations has full row rank).
  [[nodiscard]] bool generic() const;

  /// What came of a set of starts.
  struct Outcome {
    std::int64_t steps = 0;                                       ///< of all starts together
    double least_cost = std::numeric_limits<double>::infinity();  ///< half the sum of squares, of those not arrived
    Eigen::VectorXd nearest{};                                    ///< where that was
  };
  /// Writes start number `i` into `v` (within the bounds, or it is moved there). Asked again for the same start where
  /// goals that it missed are begun anew: another point each time.
  using Start = std::function<void(int i, Eigen::Ref<Eigen::VectorXd> v)>;
  /// Start `i` has arrived at `v`: every region contains the tip. False: no further start is worth it.
  using Arrival = std::function<bool(int i, const Eigen::VectorXd& v)>;
  /// Works off starts 0 .. n_starts - 1, eight at a time; the same starts give the same arrivals in the same order.
  Outcome solve(int n_starts, const Start& start, const Arrival& arrival);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace modsearch
