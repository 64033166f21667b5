#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/pose_following.hpp>
#include <modsearch/problem/timed_path_internal.hpp>

namespace modsearch::detail {
namespace {

constexpr double kMostSteps = 100'000.0;
constexpr double kStandingStill = 1e-9;  // [s]

// A path whose waypoints have times already.
TimedPath sampled(const Path& path, double time_step) {
  constexpr double kRounding = 1e-6;  // of a step
  std::vector<Eigen::VectorXd> rows{path.waypoints.row(0)};
  TimedPath result;
  result.times.push_back(path.times.front());
  result.rows_of_waypoints.push_back(0);
  const double step = std::max(time_step, (path.times.back() - path.times.front()) / kMostSteps);
  for (std::size_t i = 1; i < path.times.size(); ++i) {
    const Eigen::VectorXd from = path.waypoints.row(static_cast<Eigen::Index>(i) - 1);
    const Eigen::VectorXd to = path.waypoints.row(static_cast<Eigen::Index>(i));
    const double duration = path.times[i] - path.times[i - 1];
    const auto n = static_cast<int>(std::ceil(duration / step - kRounding));
    for (int k = 1; k < n; ++k) {
      const double part = static_cast<double>(k) / n;
      rows.emplace_back(from + part * (to - from));
      result.times.push_back(path.times[i - 1] + part * duration);
    }
    if (duration > kStandingStill) {
      rows.push_back(to);
      result.times.push_back(path.times[i]);
    } else {
      rows.back() = to;
    }
    result.rows_of_waypoints.push_back(rows.size() - 1);
  }
  result.q.resize(static_cast<Eigen::Index>(rows.size()), path.waypoints.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) result.q.row(static_cast<Eigen::Index>(i)) = rows[i];
  return result;
}

}  // namespace

TimedPath timed(const Chain& chain, const Path& path, double time_step) {
  if (!path.times.empty()) return sampled(path, time_step);
  const Eigen::MatrixXd& waypoints = path.waypoints;
  std::vector<double> durations;
  double total = 0.0;
  for (Eigen::Index i = 0; i + 1 < waypoints.rows(); ++i) {
    durations.push_back(travel_time(chain, waypoints.row(i), waypoints.row(i + 1)));
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
