#pragma once

#include <Eigen/Core>
#include <modsearch/kinematics/edge_checker_internal.hpp>
#include <vector>

namespace modsearch {

/// Shortens a path of free edges: first every waypoint that can be left out is, then `attempts` times two points of the
/// path are drawn from a fixed stream and joined by a straight edge if that is free (Geraerts and Overmars 2007,
/// Creating high-quality paths for motion planning, section 4, doi:10.1177/0278364907079280), then the first again.
/// Every edge of the result, cut ones included, has passed `checker`.
[[nodiscard]] std::vector<Eigen::VectorXd> shortened(std::vector<Eigen::VectorXd> waypoints, int attempts,
                                                     std::uint64_t stream, MotionChecker& checker);

}  // namespace modsearch
