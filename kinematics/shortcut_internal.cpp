#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/fixed_stream_internal.hpp>
#include <modsearch/kinematics/shortcut_internal.hpp>

namespace modsearch {
namespace {

using Waypoints = std::vector<Eigen::VectorXd>;

// Part of the whole length that a shortcut must save to be worth a look (arbitrary: below what one can see).
constexpr double kLeastSaving = 1e-3;

// From each kept waypoint on to the farthest one that it sees.
Waypoints without_detours(const Waypoints& waypoints, MotionChecker& checker) {
  Waypoints kept{waypoints.front()};
  for (std::size_t i = 0; i + 1 < waypoints.size();) {
    std::size_t next = waypoints.size() - 1;
    while (next > i + 1 && !checker.edge_free(waypoints[i].data(), waypoints[next].data())) --next;
    kept.push_back(waypoints[next]);
    i = next;
  }
  return kept;
}

// A point of a path: on the edge that begins at waypoint `edge`.
struct PathPoint {
  std::size_t edge;
  Eigen::VectorXd q;
};

double length(const Waypoints& waypoints) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < waypoints.size(); ++i) sum += (waypoints[i + 1] - waypoints[i]).norm();
  return sum;
}

PathPoint point_at(const Waypoints& waypoints, double way) {
  std::size_t edge = 0;
  double edge_length = (waypoints[1] - waypoints[0]).norm();
  while (way > edge_length && edge + 2 < waypoints.size()) {
    way -= edge_length;
    ++edge;
    edge_length = (waypoints[edge + 1] - waypoints[edge]).norm();
  }
  const double t = edge_length > 0.0 ? std::min(way / edge_length, 1.0) : 0.0;
  const Eigen::VectorXd& a = waypoints[edge];
  const Eigen::VectorXd& b = waypoints[edge + 1];
  // Clamped: rounding must not carry a joint past its limit.
  return {edge, (a + t * (b - a)).cwiseMax(a.cwiseMin(b)).cwiseMin(a.cwiseMax(b))};
}

}  // namespace

Waypoints shortened(Waypoints waypoints, int attempts, std::uint64_t stream, MotionChecker& checker) {
  waypoints = without_detours(waypoints, checker);
  FixedStream numbers{stream};
  for (int attempt = 0; attempt < attempts && waypoints.size() > 2; ++attempt) {
    const double whole = length(waypoints);
    const double u = numbers.next() * whole;
    const double v = numbers.next() * whole;
    const PathPoint from = point_at(waypoints, std::min(u, v));
    const PathPoint to = point_at(waypoints, std::max(u, v));
    if (from.edge == to.edge) continue;
    const double saved = std::abs(u - v) - (to.q - from.q).norm();
    if (saved < kLeastSaving * whole) continue;
    // The remainders of the two cut edges are looked at as well: their states are others than those of the whole edges.
    if (!checker.edge_free(from.q.data(), to.q.data()) ||
        !checker.edge_free(waypoints[from.edge].data(), from.q.data()) ||
        !checker.edge_free(waypoints[to.edge + 1].data(), to.q.data())) {
      continue;
    }
    const auto begin = waypoints.begin();
    Waypoints cut(begin, begin + static_cast<std::ptrdiff_t>(from.edge) + 1);
    cut.push_back(from.q);
    cut.push_back(to.q);
    cut.insert(cut.end(), begin + static_cast<std::ptrdiff_t>(to.edge) + 1, waypoints.end());
    waypoints = std::move(cut);
  }
  return without_detours(waypoints, checker);
}

}  // namespace modsearch
