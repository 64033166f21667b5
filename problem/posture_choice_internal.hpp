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
  /// [m]; more than `obstacle_clearance` is not told apart.
  double self_clearance = std::numeric_limits<double>::infinity();
  Failure touches = Failure::kNone;  ///< kObstacle, kSelfCollision: known without a distance
  double torque_share = 0.0;         ///< see Attempt

  [[nodiscard]] double clearance() const { return std::min(obstacle_clearance, self_clearance); }
  [[nodiscard]] bool holds() const { return torque_share <= 1.0; }
  [[nodiscard]] Failure collision() const {
    if (touches != Failure::kNone) return touches;
    if (obstacle_clearance < 0.0) return Failure::kObstacle;
    return self_clearance < 0.0 ? Failure::kSelfCollision : Failure::kNone;
  }
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

  /// `load`: what acts on the arm there. Clearances above `ceiling` are not told apart.
  [[nodiscard]] Candidate judge(const Eigen::VectorXd& q, const StaticLoad& load, Work& work,
                                double ceiling = std::numeric_limits<double>::infinity());
  /// The best of equally close postures; the first of these if several tie. `ceiling`: of a single one.
  [[nodiscard]] Candidate best(const IkSolution& solution, const StaticLoad& load, double ceiling, Work& work);
  /// One of equally close postures that touches nothing, the first, else the first of all: without clearances and
  /// torques, for a task that is not fulfilled all the same.
  [[nodiscard]] Candidate free_one(const IkSolution& solution, Work& work);
  /// Those of equally close postures that hold and touch nothing, no two of them alike, the largest clearance first;
  /// without `first`.
  [[nodiscard]] std::vector<Candidate> others(const IkSolution& solution, const Eigen::VectorXd& first,
                                              const StaticLoad& load, Work& work);

 private:
  void pose(const Eigen::VectorXd& q, Work& work);
  // What arm and scene overlap at the posture that was posed last.
  [[nodiscard]] Failure touched(Work& work) const;
  // The clearances there; given up as soon as they are known to be at most `floor`.
  void measure(Candidate& candidate, double ceiling, double floor, Work& work) const;
  [[nodiscard]] double share(const StaticLoad& load) const;

  const Arm& arm_;
  const Scene& scene_;
  Level level_;
  bool torques_ = false;
  bool choosy_ = false;
  bool meshes_ = false;  // distances are much dearer than verdicts
  IkOptions ik_;
  Posture posture_;  // memory to work in
};

}  // namespace modsearch::detail
