#pragma once

#include <modsearch/problem/robot_problem.hpp>
#include <optional>
#include <string>
#include <vector>

namespace modsearch {

/// Two bodies that overlap, or a body and an obstacle.
struct Touch {
  int body = -1;         ///< index into Chain::bodies()
  bool obstacle = true;  ///< what `other` counts: the scene's obstacles, or the bodies of the arm
  int other = -1;
  double depth = 0.0;  ///< the least translation that parts them [m]
  /// The deepest points of the two, world frame [m].
  Eigen::Vector3d p_WA = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
};

/// One thing that keeps a design from being achieved. What does not belong to `why` stays at its default.
struct Miss {
  Failure why = Failure::kUnreachable;
  std::string place{};    ///< "goal 2", "pose 17 of trajectory weld", "home"; empty: the design as a whole, or a leg
  int goal = -1;          ///< index into Task::goals(); of a trajectory the knot at or behind the pose; -1: at no goal
  double distance = 0.0;  ///< a pose: how far the tip is outside the tolerances of its position [m]
  double angle = 0.0;     ///< and outside those that are angles [rad]
  double away = 0.0;      ///< and its distance from the nominal position [m]
  std::optional<Touch> touch{};  ///< kObstacle, kSelfCollision, kHomeInCollision: the deepest overlap there
  std::string
      joint{};  ///< kTorque: the joint that has to hold the largest share of its peak torque; kLimit: at its end
  double torque_share = 0.0;
  std::string from{};   ///< kNoPath: where the leg begins for which no path was found: "home", "goal 1"
  std::string to{};     ///< and where it leads; "goal 2 or goal 3" where the order is free
  std::string words{};  ///< for people: "goal 2: 12.3 mm and 4.1 degrees outside its tolerance"
};

/// What keeps a design from being achieved.
struct NearestMiss {
  /// The first thing at each goal, in the order of goals, whatever kept the motion from its end behind them. Empty for
  /// a design that is achieved, otherwise at least one.
  std::vector<Miss> misses;

  /// The words of all of them, parted by semicolons.
  [[nodiscard]] std::string words() const;
};

/// Looks again at an attempt that failed and says which goal is missed by how much, what overlaps how deep, which joint
/// is too weak, or between which goals no path was found. `evaluation` is that of `problem` at full fidelity for
/// `design`, whose postures it looks at. Costs some forward kinematics and distances, after the fact: searches pay
/// nothing for it.
/// A task with an attempt of its own may leave no postures of the usual shape: then the reason alone is told.
/// Throws std::invalid_argument for a design outside the search space.
[[nodiscard]] NearestMiss nearest_miss(const RobotProblem& problem, const Design& design, const Evaluation& evaluation);

}  // namespace modsearch
