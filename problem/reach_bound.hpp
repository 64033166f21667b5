#pragma once

#include <modsearch/kinematics/chain.hpp>
#include <modsearch/kinematics/pose_region.hpp>
#include <modsearch/problem/design.hpp>

namespace modsearch {

/// What the triangle inequality says about reaching a region with a chain whose parameters lie in a box.
struct ReachBound {
  bool possible = true;     ///< false: proved that no parameters and no posture reach the region
  double distance = 0.0;    ///< from the base to the nominal position [m]
  double span = 0.0;        ///< longest stretched chain within the box [m]
  double least_mass = 0.0;  ///< no parameters that reach weigh less [kg]
};

/// The tip is never farther from the base at `p_WB` than the chain is long, so that length >= distance - tolerance. The
/// lightest parameters that are long enough come from a fractional knapsack: both mass and an upper bound of the length
/// are affine in the parameters, so they are lengthened in order of length per mass.
[[nodiscard]] ReachBound reach_bound(const Chain& chain, const ParameterBox& box, const Eigen::Vector3d& p_WB,
                                     const PoseRegion& region);

}  // namespace modsearch
