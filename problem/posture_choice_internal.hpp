#pragma once

#include <limits>
#include <modsearch/problem/task.hpp>

namespace modsearch::detail {

/// Whether a level looks at obstacles; and at pairs of bodies of the arm itself.
[[nodiscard]] bool looks_at_obstacles(Level level);
[[nodiscard]] bool looks_at_itself(Level level);

/// How a posture stands to what it must not touch and to what it has to hold.
struct Candidate {
  Eigen::VectorXd q;
  double obstacle_clearance = std::numeric_limits<double>::infinity();  ///< [m]
  double self_clearance = std::numeric_limits<double>::infinity();
  double torque_share = 0.0;  ///< see Attempt

  [[nodiscard]] double clearance() const { return std::min(obstacle_clearance, self_clearance); }
  [[nodiscard]] bool holds() const { return torque_share <= 1.0; }
  /// Postures that the joints can hold come first, then the larger clearance counts.
  [[nodiscard]] bool better_than(const Candidate& other) const {
    return holds() != other.holds() ? holds() : clearance() > other.clearance();
  }
};

/// Looks at postures of one arm at one level.
class PostureJudge {
 public:
  PostureJudge(const Task& task, const Arm& arm, const Scene& scene, const AttemptOptions& options);

  /// Anything can be told apart at all: else one of several postures is as good as another.
  [[nodiscard]] bool choosy() const { return choosy_; }
  /// Options of inverse kinematics that give every posture worth looking at.
  [[nodiscard]] const IkOptions& ik() const { return ik_; }

  /// `load`: what acts on the arm there.
  [[nodiscard]] Candidate judge(const Eigen::VectorXd& q, const StaticLoad& load, Work& work);
  /// The best of equally close postures; the first of these if several tie.
  [[nodiscard]] Candidate best(const IkSolution& solution, const StaticLoad& load, Work& work);

 private:
  const Arm& arm_;
  const Scene& scene_;
  Level level_;
  bool torques_ = false;
  bool choosy_ = false;
  IkOptions ik_;
  Posture posture_;  // memory to work in
};

}  // namespace modsearch::detail
