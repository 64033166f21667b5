#pragma once

#include <memory>
#include <modsearch/kinematics/pose_region.hpp>
#include <modsearch/kinematics/statics.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace modsearch {

enum class GoalType {
  kAt,      ///< pass the pose
  kReach,   ///< be there with zero velocity of the TCP
  kFollow,  ///< a pose on a trajectory
};
[[nodiscard]] std::string_view name(GoalType type);

/// Where the tip has to be: every goal gets a posture of its own.
struct Goal {
  std::string id;
  GoalType type = GoalType::kReach;
  PoseRegion region;
  Wrench wrench{};  ///< what acts on the tip there, beside the payload

  [[nodiscard]] Eigen::Vector3d position() const { return region.nominal().translation(); }
};

/// Poses to be followed in order, by joints that move continuously.
struct Trajectory {
  std::vector<PoseRegion> poses;
  std::vector<double> times{};  ///< of the poses, from the first one, rising [s]; empty: as fast as the joints may
};

/// Poses between those of `trajectory`, so close that neighbours are at most `length` [m] and `angle` [rad] apart: on
/// straight lines, turned about one axis, with the tolerances of the pose that they lead to. A posture that is found
/// from its neighbour then stays on its branch.
[[nodiscard]] Trajectory resampled(const Trajectory& trajectory, double length = 0.02, double angle = 0.1);

/// One thing that has to be done.
struct TaskStep {
  enum class Kind {
    kVisit,   ///< assume the posture of a goal
    kFollow,  ///< run along a trajectory
    kPause,   ///< stand still
    kReturn,  ///< assume an earlier posture again, joint by joint
  };
  std::string id;
  Kind kind = Kind::kVisit;
  int goal = 0;     ///< index into Task::goals(); kFollow: the first of its knots; kReturn: whose posture, -1: home
  int n_goals = 1;  ///< kFollow: number of knots, the others 1
  std::shared_ptr<const Trajectory> trajectory{};  ///< kFollow: all poses
  std::vector<int>
      knots{};  ///< kFollow: which of the poses are goals [n_goals], rising, the first and the last among them
  double duration = 0.0;  ///< kPause [s]
};

/// A trajectory as a step and its goals: at most `most_knots` of its poses become goals, evenly spread. The attempt
/// follows every pose; the smooth program and the agents know the knots.
/// Throws std::invalid_argument for fewer than two poses or knots, and for times that are not as many or do not rise.
struct FollowStep {
  TaskStep step;
  std::vector<Goal> goals;
};
[[nodiscard]] FollowStep follow(const std::string& id, const Trajectory& trajectory, int first_goal,
                                const Wrench& wrench = {}, int most_knots = 8);

}  // namespace modsearch
