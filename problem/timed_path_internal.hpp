#pragma once

#include <modsearch/kinematics/path_planning.hpp>

namespace modsearch::detail {

/// A path with times, in rows that are one time step apart (where a path that has times allows).
struct TimedPath {
  std::vector<double> times;                   ///< [n_rows] s, from 0
  Eigen::MatrixXd q;                           ///< [n_rows x n_joints]
  std::vector<std::size_t> rows_of_waypoints;  ///< row of each waypoint of the path
};

/// A path that has times keeps them: rows at every waypoint, and between them so that none are farther apart than a
/// step. Otherwise runs along `path` as fast as the slowest joint of each segment may (1 rad/s or 1 m/s where its
/// velocity is not limited), stretching each segment to whole time steps: no corner is cut, and a timed path timed
/// again stays the same. The step grows where the motion would take more than 100 000 of them.
[[nodiscard]] TimedPath timed(const Chain& chain, const Path& path, double time_step);

}  // namespace modsearch::detail
