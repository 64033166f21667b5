#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/problem/robot_problem.hpp>

namespace modsearch::testing {

/// What every Task promises of an attempt with `arm`.
inline void expect_sound_attempt(const Task& task, const Arm& arm, const Scene& scene, const AttemptOptions& options) {
  const Attempt attempt = task.attempt(arm, scene, options);
  const Attempt again = task.attempt(arm, scene, options);
  EXPECT_EQ(attempt.postures, again.postures) << "an attempt is a function of its arguments";
  EXPECT_EQ(attempt.goal_error, again.goal_error);
  EXPECT_EQ(attempt.achieved, again.achieved);

  const auto n_goals = static_cast<Eigen::Index>(task.goals().size());
  ASSERT_EQ(attempt.postures.rows(), n_goals) << "a posture per goal";
  ASSERT_EQ(attempt.postures.cols(), arm.n_joints());
  EXPECT_TRUE(attempt.postures.allFinite());
  EXPECT_TRUE(std::isfinite(attempt.goal_error));
  EXPECT_GE(attempt.goal_error, 0.0);
  EXPECT_EQ(attempt.achieved, attempt.why == Failure::kNone) << "a failure has a reason, a success has none";
  EXPECT_TRUE(!attempt.achieved || (attempt.reached && !attempt.collides));
  EXPECT_FALSE(options.level == Level::kNone && attempt.collides) << "nothing collides at level none";
  bool all = true;
  for (Eigen::Index goal = 0; goal < n_goals; ++goal) {
    const Eigen::VectorXd q = attempt.postures.row(goal).transpose();
    EXPECT_TRUE(arm.chain().clamped(q).isApprox(q, 1e-9)) << "postures are within the joint limits";
    all = all && task.goals()[static_cast<std::size_t>(goal)].region.contains(arm.forward(q).tip);
  }
  EXPECT_TRUE(all || !attempt.reached) << "reached means that the postures show it";
  EXPECT_EQ(attempt.relative_error == 0.0, attempt.reached) << "an error that counts, exactly where a goal is missed";
  EXPECT_TRUE(!attempt.achieved || attempt.torque_share <= 1.0);

  // Trajectories: every pose, from the start to where it was left off, and no jumps.
  std::size_t trajectory = 0;
  for (const TaskStep& step : task.steps()) {
    if (step.kind != TaskStep::Kind::kFollow) continue;
    ASSERT_LT(trajectory, attempt.trajectories.size());
    const Eigen::MatrixXd& rows = attempt.trajectories[trajectory++];
    ASSERT_EQ(rows.rows(), static_cast<Eigen::Index>(step.trajectory->poses.size()));
    for (Eigen::Index k = 0; k < rows.rows(); ++k) {
      const Posture posture = arm.forward(rows.row(k).transpose());
      EXPECT_TRUE(!attempt.reached || step.trajectory->poses[static_cast<std::size_t>(k)].contains(posture.tip));
      if (k == 0 || arm.n_joints() == 0) continue;
      EXPECT_LE((rows.row(k) - rows.row(k - 1)).cwiseAbs().maxCoeff(), options.follow.largest_step);
    }
  }
  if (attempt.path && attempt.achieved) {
    const Eigen::MatrixXd& waypoints = attempt.path->waypoints;
    EXPECT_EQ(waypoints.row(0).transpose(), home_posture(task, arm, scene)) << "a motion begins at home";
    ASSERT_EQ(attempt.goal_waypoints.size(), static_cast<std::size_t>(n_goals));
    ASSERT_EQ(attempt.step_waypoints.size(), steps_of(task).size());
    EXPECT_TRUE(task.any_order() || std::is_sorted(attempt.step_waypoints.begin(), attempt.step_waypoints.end()));
    const std::vector<double>& times = attempt.path->times;
    ASSERT_EQ(times.empty(), !is_timed(task, scene)) << "times where they matter";
    for (std::size_t i = 1; i < times.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      EXPECT_GE(times[i], times[i - 1]);
      for (int j = 0; j < arm.n_joints(); ++j) {
        const double way = std::abs(waypoints(row, j) - waypoints(row - 1, j));
        const double velocity = arm.chain().joints()[static_cast<std::size_t>(j)].velocity;
        EXPECT_TRUE(way <= velocity * (times[i] - times[i - 1]) * (1.0 + 1e-9)) << "no joint is faster than it may be";
      }
    }
    for (Eigen::Index goal = 0; goal < n_goals; ++goal) {
      EXPECT_EQ(waypoints.row(attempt.goal_waypoints[static_cast<std::size_t>(goal)]), attempt.postures.row(goal));
    }
  }
}

/// What every Task promises; run it on yours, within a problem that has it. Draws `designs` random designs.
inline void expect_task_contract(const RobotProblem& problem, int designs = 20) {
  const Task& task = problem.task();
  SCOPED_TRACE(std::string{task.name()});
  EXPECT_FALSE(task.name().empty());
  ASSERT_FALSE(task.goals().empty());
  EXPECT_EQ(task.goals().data(), task.goals().data()) << "goals do not change";
  EXPECT_TRUE(task.features().allFinite());
  EXPECT_EQ(task.features(), task.features());

  Rng rng{11};
  for (int i = 0; i < designs; ++i) {
    const Design drawn = random_design(problem, rng);
    const Design design = drawn.prefix(std::min(3, static_cast<int>(drawn.modules.size())));
    const std::vector<int> types = design.types();
    const std::shared_ptr<const Chain> chain = problem.chain(types);
    const Arm arm = chain->at(design.parameters());
    for (const Level level : {Level::kNone, Level::kPosture, Level::kPostureSelf, Level::kPath}) {
      expect_sound_attempt(task, arm, problem.scene(), {.level = level, .ik = problem.spec().ik, .planner = {}});
    }

    // The rows of the smooth program are finite and have the derivatives they claim.
    const std::unique_ptr<SmoothProgram> program = problem.relax(types);
    if (program == nullptr || !problem.scene().obstacles().empty()) continue;
    const Eigen::VectorXd v = program->start(i);
    SmoothProgram::Values at, above, below;
    program->evaluate(v, at);
    ASSERT_TRUE(at.rows.allFinite());
    constexpr double kStep = 1e-6;
    for (int j = 0; j < program->n_variables(); ++j) {
      const Eigen::VectorXd e = kStep * Eigen::VectorXd::Unit(program->n_variables(), j);
      program->evaluate(v + e, above);
      program->evaluate(v - e, below);
      const Eigen::VectorXd slope = (above.rows - below.rows) / (2.0 * kStep);
      // Rounding leaves about 1e-10 / 1e-6 of a central difference.
      EXPECT_LT((at.jacobian.col(j) - slope).cwiseAbs().maxCoeff(), 1e-5) << "variable " << j;
    }
  }
}

}  // namespace modsearch::testing
