#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <modsearch/kinematics/edge_checker_internal.hpp>
#include <vector>

namespace modsearch {

/// What RRT-Connect came to.
struct RrtConnectResult {
  std::vector<Eigen::VectorXd> waypoints;  ///< from start to goal, every edge passed the checker; empty: none found
  std::int64_t iterations = 0;             ///< samples drawn
};

/// OMPL's RRT-Connect (Kuffner and LaValle 2000, doi:10.1109/ROBOT.2000.844730) between two free states of the joint
/// box `lower`..`upper`, made a function of its arguments: an own sampler with a fixed stream, linear nearest
/// neighbours, an end by the number of samples.
[[nodiscard]] RrtConnectResult rrt_connect(const Eigen::VectorXd& q_start, const Eigen::VectorXd& q_goal,
                                           const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                                           std::int64_t max_iterations, std::uint64_t stream, MotionChecker& checker);

}  // namespace modsearch
