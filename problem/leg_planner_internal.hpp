#pragma once

#include <map>
#include <modsearch/problem/task.hpp>
#include <vector>

namespace modsearch::detail {

/// Plans motions of one arm from posture to posture, and knows those that it has planned: when a posture of a task is
/// exchanged, most of the motion stays what it was.
class LegPlanner {
 public:
  /// All of it must outlive the planner.
  LegPlanner(const Arm& arm, const Scene& scene, const AttemptOptions& options);

  /// From `from` at time `start` [s] to `to`, where the arm may stand for `hold` seconds. The times count where
  /// obstacles move, and such motions are not remembered. `work` gets what is done now.
  [[nodiscard]] Plan plan(const Eigen::VectorXd& from, double start, const Eigen::VectorXd& to, double hold,
                          Work& work);

  /// Iterations that the planner may spend on a leg from now on.
  void limit(std::int64_t iterations) { options_.max_iterations = iterations; }
  /// Legs on which the planner has spent all its iterations in vain.
  [[nodiscard]] int failures() const { return failures_; }

 private:
  const Arm& arm_;
  const Scene& scene_;
  PlanOptions options_;
  std::map<std::vector<double>, Plan> known_;  // by both postures
  int failures_ = 0;
};

}  // namespace modsearch::detail
