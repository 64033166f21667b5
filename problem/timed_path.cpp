#include <algorithm>
#include <cmath>
#include <modsearch/problem/timed_path_internal.hpp>

namespace modsearch::detail {
namespace {

constexpr double kMostSteps = 100'000.0;
constexpr double kStandingStill = 1e-9;  // [s]

/// Least time from one waypoint to the next [s].
double duration(const Chain& chain, const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  double seconds = 0.0;
  for (int j = 0; j < chain.n_joints(); ++j) {
    const double limit = chain.joints()[static_cast<std::size_t>(j)].velocity;
    seconds = std::max(seconds, std::abs(to[j] - from[j]) / (std::isfinite(limit) ? limit : 1.0));
  }
  return seconds;
}

}  // namespace

TimedPath timed(const Chain& chain, const Path& path, double time_step) {
  const Eigen::MatrixXd& waypoints = path.waypoints;
  std::vector<double> durations;
  double total = 0.0;
  for (Eigen::Index i = 0; i + 1 < waypoints.rows(); ++i) {
    durations.push_back(duration(chain, waypoints.row(i), waypoints.row(i + 1)));
    total += durations.back();
  }
  const double step = std::max(time_step, total / kMostSteps);

  std::vector<Eigen::VectorXd> rows{waypoints.row(0)};
  TimedPath result;
  result.rows_of_waypoints.push_back(0);
  for (std::size_t i = 0; i < durations.size(); ++i) {
    constexpr double kRounding = 1e-6;  // of a step: a segment of exactly n steps takes n
    auto n = static_cast<int>(std::ceil(durations[i] / step - kRounding));
    // However long the step, a motion is not rounding: it would begin where it ends.
    if (n == 0 && durations[i] > kStandingStill) n = 1;
    const Eigen::VectorXd from = waypoints.row(static_cast<Eigen::Index>(i));
    const Eigen::VectorXd to = waypoints.row(static_cast<Eigen::Index>(i) + 1);
    for (int k = 1; k < n; ++k) rows.emplace_back(from + (static_cast<double>(k) / n) * (to - from));
    if (n > 0) {
      rows.push_back(to);
    } else {
      rows.back() = to;  // less than rounding away: the same row
    }
    result.rows_of_waypoints.push_back(rows.size() - 1);
  }
  result.q.resize(static_cast<Eigen::Index>(rows.size()), waypoints.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    result.q.row(static_cast<Eigen::Index>(i)) = rows[i];
    result.times.push_back(static_cast<double>(i) * step);
  }
  return result;
}

}  // namespace modsearch::detail
