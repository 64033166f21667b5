#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/problem/goal.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr double kSameRotation = 1e-9;

// The region on the way from `from` to `to`, at `part` of it: tolerances of `to`, in frames that stay as they are there
// where these are fixed in the world, and turn with the pose otherwise.
PoseRegion between(const PoseRegion& from, const PoseRegion& to, double part) {
  const Eigen::Isometry3d& X_WA = from.nominal();
  const Eigen::Isometry3d& X_WB = to.nominal();
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = X_WA.translation() + part * (X_WB.translation() - X_WA.translation());
  X.linear() =
      Eigen::Quaterniond{X_WA.linear()}.slerp(part, Eigen::Quaterniond{X_WB.linear()}).normalized().toRotationMatrix();
  std::vector<Tolerance> tolerances = to.tolerances();
  const auto of_world = [](const PoseRegion& region, std::size_t i) {
    return i < region.tolerances().size() &&
           region.tolerances()[i].R_TN.isApprox(region.nominal().linear(), kSameRotation);
  };
  for (std::size_t i = 0; i < tolerances.size(); ++i) {
    if (of_world(from, i) && of_world(to, i)) tolerances[i].R_TN = X.linear();
  }
  return {X, std::move(tolerances)};
}

int parts_between(const PoseRegion& a, const PoseRegion& b, double length, double angle) {
  const double way = (b.nominal().translation() - a.nominal().translation()).norm();
  const double turn =
      Eigen::Quaterniond{a.nominal().linear()}.angularDistance(Eigen::Quaterniond{b.nominal().linear()});
  const bool turns_count = a.constrains_orientation() && b.constrains_orientation();
  constexpr double kRounding = 1e-9;  // poses exactly one length apart need nothing between them
  const double parts = std::max(way / length, turns_count ? turn / angle : 0.0);
  return std::max(1, static_cast<int>(std::ceil(parts - kRounding)));
}

}  // namespace

std::string_view name(GoalType type) {
  switch (type) {
    case GoalType::kAt:
      return "at";
    case GoalType::kReach:
      return "reach";
    case GoalType::kFollow:
      return "follow";
  }
  return "";
}

Trajectory resampled(const Trajectory& trajectory, double length, double angle) {
  if (!(length > 0.0) || !(angle > 0.0)) {
    throw std::invalid_argument(fmt::format("resampled: steps of {} m and {} rad, must be above 0", length, angle));
  }
  if (trajectory.poses.empty()) return trajectory;
  Trajectory result;
  const bool timed = !trajectory.times.empty();
  result.poses.push_back(trajectory.poses.front());
  if (timed) result.times.push_back(trajectory.times.front());
  for (std::size_t i = 1; i < trajectory.poses.size(); ++i) {
    const PoseRegion& from = trajectory.poses[i - 1];
    const PoseRegion& to = trajectory.poses[i];
    const int parts = parts_between(from, to, length, angle);
    for (int k = 1; k <= parts; ++k) {
      const double part = static_cast<double>(k) / parts;
      result.poses.push_back(k == parts ? to : between(from, to, part));
      if (timed) result.times.push_back(std::lerp(trajectory.times[i - 1], trajectory.times[i], part));
    }
  }
  return result;
}

FollowStep follow(const std::string& id, const Trajectory& trajectory, int first_goal, const Wrench& wrench,
                  int most_knots) {
  const std::size_t n = trajectory.poses.size();
  if (n < 2 || most_knots < 2) {
    throw std::invalid_argument(
        fmt::format("trajectory '{}': {} poses and {} knots, at least 2 of each are needed", id, n, most_knots));
  }
  const std::vector<double>& times = trajectory.times;
  if (!times.empty() && times.size() != n) {
    throw std::invalid_argument(fmt::format("trajectory '{}': {} times for {} poses", id, times.size(), n));
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || (i > 0 && times[i] <= times[i - 1])) {
      throw std::invalid_argument(
          fmt::format("trajectory '{}': time {} is {} s, must be later than the one before it", id, i, times[i]));
    }
  }
  FollowStep result;
  result.step = {.id = id, .kind = TaskStep::Kind::kFollow, .goal = first_goal};
  result.step.trajectory = std::make_shared<const Trajectory>(resampled(trajectory));
  const std::vector<PoseRegion>& poses = result.step.trajectory->poses;
  const auto last = static_cast<int>(poses.size()) - 1;
  const int n_knots = std::min(most_knots, last + 1);
  for (int k = 0; k < n_knots; ++k) {
    const int knot = k * last / (n_knots - 1);
    result.step.knots.push_back(knot);
    result.goals.push_back(
        {fmt::format("{}/{}", id, knot), GoalType::kFollow, poses[static_cast<std::size_t>(knot)], wrench});
  }
  result.step.n_goals = n_knots;
  return result;
}

}  // namespace modsearch
