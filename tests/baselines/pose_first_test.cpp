#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/baselines/auto_solver.hpp>
#include <modsearch/baselines/pose_first.hpp>
#include <modsearch/baselines/pose_first/sequence_belief_internal.hpp>
#include <modsearch/baselines/pose_first/sequence_change_internal.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/robot_problem.hpp>

#include "baselines/tiny_problems.hpp"

namespace modsearch {
namespace {

using ::testing::HasSubstr;

// Three full poses among three boxes, drawn with a seed that nothing was tuned on.
std::shared_ptr<const RobotProblem> three_poses(std::uint64_t index) {
  return load_problem("whitman/3g_3o", {.seed = 5, .index = index});
}

TEST(PoseFirst, BringsRealArmsToThreePosesAmongBoxesWithAVerifiedPath) {
  int achieved = 0;
  for (std::uint64_t index = 0; index < 4; ++index) {
    const auto problem = three_poses(index);
    Meter meter{{.evaluations = 300}};
    const Solution solution = PoseFirst{}.solve(*problem, meter, Rng{1});
    if (!solution.evaluation.attempt.achieved) continue;
    ++achieved;
    // Once more, from nothing but the design and its postures.
    const Evaluation again =
        problem->evaluate(solution.design, Fidelity::kFull, {.postures = solution.evaluation.attempt.postures});
    EXPECT_TRUE(again.attempt.achieved);
    EXPECT_DOUBLE_EQ(again.score, solution.evaluation.score);
    ASSERT_TRUE(again.attempt.path.has_value());
    // The search had little patience with the planner: what it found is what patience finds.
    ASSERT_TRUE(solution.evaluation.attempt.path.has_value());
    EXPECT_EQ(again.attempt.path->waypoints, solution.evaluation.attempt.path->waypoints);
  }
  EXPECT_GE(achieved, 2);
}

TEST(PoseFirst, GivesTheSameAnswerForTheSameSeed) {
  const auto problem = three_poses(1);
  const auto solved = [&] {
    Meter meter{{.evaluations = 120}};
    return PoseFirst{}.solve(*problem, meter, Rng{3});
  };
  const Solution first = solved();
  const Solution second = solved();
  EXPECT_EQ(first.design, second.design);
  EXPECT_EQ(first.evaluation.score, second.evaluation.score);
}

TEST(PoseFirst, SaysSoWhereAProblemHasNoPoses) {
  const testing::Stacks stacks{{.library = testing::blocks({true}), .values = {1.0}, .goal = 1}};
  ASSERT_FALSE(PoseFirst::covers(stacks));
  Meter meter;
  const Solution solution = PoseFirst{}.solve(stacks, meter, Rng{1});
  EXPECT_EQ(solution.stop, StopReason::kExhausted);
  EXPECT_THAT(solution.reason, HasSubstr("no poses that could be solved for"));
}

TEST(PoseFirst, RefusesOptionsThatTryNothing) {
  EXPECT_THROW(PoseFirst{{.starts = 0}}, std::invalid_argument);
  EXPECT_THROW(PoseFirst{{.iterations = 0}}, std::invalid_argument);
}

TEST(PoseFirst, IsWhatTheDefaultSolverUsesForFullPosesAndItSaysWhy) {
  const auto problem = three_poses(0);
  Meter meter{{.evaluations = 5}};
  const std::unique_ptr<Search> search = AutoSolver{}.start(*problem, Rng{1});
  while (!search->step(meter)) {
  }
  EXPECT_THAT(meter.stage(), HasSubstr("sequences"));
}

TEST(SequenceBelief, DrawsWhatSucceededMoreOften) {
  const auto problem = three_poses(0);
  const int bent = problem->library().find("drive_60_bent").value();
  detail::SequenceBelief belief{*problem, Rng{1}};
  const auto share = [&] {
    Rng rng{7};
    int with = 0;
    int pairs = 0;
    for (int i = 0; i < 300; ++i) {
      const auto drawn = belief.draw(-1000.0, rng);
      if (!drawn) continue;
      for (std::size_t k = 0; k + 1 < drawn->types.size(); ++k) {
        ++pairs;
        with += drawn->types[k] == bent && drawn->types[k + 1] == bent ? 1 : 0;
      }
    }
    return static_cast<double>(with) / pairs;
  };
  const double before = share();
  Rng rng{2};
  for (int i = 0; i < 400; ++i) {
    const auto drawn = belief.draw(-1000.0, rng);
    ASSERT_TRUE(drawn.has_value());
    bool pair = false;
    for (std::size_t k = 0; k + 1 < drawn->types.size(); ++k) {
      pair = pair || (drawn->types[k] == bent && drawn->types[k + 1] == bent);
    }
    belief.learn(drawn->types, pair ? 1.0 : 0.0, 100.0);
  }
  EXPECT_GT(share(), 1.5 * before);
}

TEST(SequenceBelief, TellsNothingThatCouldNotBeatTheBest) {
  const auto problem = three_poses(0);
  detail::SequenceBelief belief{*problem, Rng{1}};
  Rng rng{2};
  for (int i = 0; i < 100; ++i) {
    const auto drawn = belief.draw(40.0, rng);
    ASSERT_TRUE(drawn.has_value());
    EXPECT_GT(problem->optimism(drawn->types).score, 40.0);
  }
  EXPECT_FALSE(belief.draw(1e6, rng).has_value());
}

TEST(SequenceChange, KeepsTheNumbersOfTheModulesThatStay) {
  const auto problem = three_poses(0);
  const ModuleLibrary& library = problem->library();
  std::vector<int> types;
  for (const char* id : {"adapter_120_60", "drive_60_inline", "link_60", "drive_60_bent", "gripper_60"}) {
    types.push_back(library.find(id).value());
  }
  // (length, twist), then two joints for each of three goals: every number tells where it stands.
  const Eigen::VectorXd old = Eigen::VectorXd::LinSpaced(8, 0.1, 0.8);
  Rng rng{4};
  for (int trial = 0; trial < 100; ++trial) {
    const auto change = detail::changed(*problem, types, rng);
    ASSERT_TRUE(change.has_value());
    EXPECT_NE(change->types, types);
    EXPECT_TRUE(library.fits_together(change->types));
    EXPECT_TRUE(library.complete(change->types));
    const auto n_x = static_cast<Eigen::Index>(change->parameters.size());
    const auto n_q = static_cast<Eigen::Index>(change->joints.size());
    // Bounds without width leave what stays unshaken.
    const Eigen::VectorXd bound = Eigen::VectorXd::Constant(n_x + 3 * n_q, -1.0);
    Eigen::VectorXd v(bound.size());
    detail::carry_over(*change, old, 0, bound, bound, rng, v);
    for (Eigen::Index p = 0; p < n_x; ++p) {
      const int from = change->parameters[static_cast<std::size_t>(p)];
      EXPECT_DOUBLE_EQ(v[p], from < 0 ? -1.0 : old[from]);
    }
    for (Eigen::Index g = 0; g < 3; ++g) {
      for (Eigen::Index j = 0; j < n_q; ++j) {
        const int from = change->joints[static_cast<std::size_t>(j)];
        EXPECT_DOUBLE_EQ(v[n_x + g * n_q + j], from < 0 ? -1.0 : old[2 + 2 * g + from]);
      }
    }
  }
}

}  // namespace
}  // namespace modsearch
