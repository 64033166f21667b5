#pragma once

#include <modsearch/problem/posture_choice_internal.hpp>

namespace modsearch::detail {

/// Fulfils a task goal by goal and trajectory by trajectory, and adds up what came of it: an attempt but for the motion
/// from one to the next.
class Trial {
 public:
  /// All of it must outlive the trial.
  Trial(const Task& task, const Arm& arm, const Scene& scene, const AttemptOptions& options);

  /// Looks for postures at a goal that is visited. Before any of what follows, at all such goals.
  void seek(int goal);
  /// One of the goal's postures: the best one where everything sought is reached. Else any that touches nothing.
  void visit(int goal);
  /// Postures for all poses of the trajectory. The arm may begin in one of several: the one from which it gets farthest
  /// counts, among those from which it gets through the best one on the whole way.
  void follow(const TaskStep& step);

  [[nodiscard]] Attempt& attempt() { return attempt_; }
  /// What is overlapped at the postures, the first thing.
  [[nodiscard]] Failure collision() const { return collision_; }
  /// The arm misses a goal, whatever the starts of a search: by its reach, or by exact inverse kinematics.
  [[nodiscard]] bool sure_to_miss() const { return sure_to_miss_; }

  /// How many postures are free at goal `goal`, the one that the attempt began with among them. Of a goal on a
  /// trajectory: 1.
  [[nodiscard]] int n_choices(int goal);
  /// The attempt passes through the posture number `choice` of the goal from now on. 0: the one that it began with.
  void choose(int goal, int choice);

  /// The attempt as it stands.
  [[nodiscard]] Attempt result() &&;

 private:
  static constexpr int kMostStarts = 16;  // postures from which a trajectory is tried (arbitrary)

  [[nodiscard]] Eigen::VectorXd witnessed(int goal) const;
  [[nodiscard]] IkSolution begun(const TaskStep& step);
  // From `q`, or from the same posture whole turns away, whichever gets farthest.
  [[nodiscard]] Following followed(const Trajectory& trajectory, const Eigen::VectorXd& q);
  [[nodiscard]] const std::vector<Candidate>& choices(int goal);
  void count(std::int64_t iterations, std::int64_t forward);
  void fail(Failure why, double relative_error);
  void miss(const Goal& goal, const IkSolution& ik);
  // Takes what was seen at the posture of a goal, or along a trajectory, into the account.
  void look_at(const Candidate& chosen);
  // The least clearances and the largest share of a torque along the poses that were followed.
  [[nodiscard]] Candidate worst_along(const Following& way, const TaskStep& step);

  const Task& task_;
  const Arm& arm_;
  const AttemptOptions& options_;
  bool witnessed_;
  PostureJudge judge_;
  Attempt attempt_;
  Failure collision_ = Failure::kNone;
  bool sure_to_miss_ = false;
  int errors_ = 0;                               // goals and trajectories: what the relative error is the mean over
  std::vector<IkSolution> found_;                // [n_goals]; of goals on trajectories without postures
  std::vector<std::vector<Candidate>> choices_;  // [n_goals]: the first one, and the others once they were asked for
  std::vector<bool> all_choices_;                // [n_goals]: they were
  std::vector<Candidate> followed_;              // the worst along each trajectory
  bool moved_ = false;                           // some posture is not the one that the attempt began with
};

}  // namespace modsearch::detail
