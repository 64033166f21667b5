#include <gtest/gtest.h>

#include <modsearch/baselines/random_search.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/solvers/verification.hpp>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

// A random design of two modules or more that is achieved.
std::optional<Design> drawn(const RobotProblem& problem, Rng& rng) {
  for (int i = 0; i < 2000; ++i) {
    Design design = random_design(problem, rng);
    if (design.modules.size() < 2 || design.modules.size() > 5) continue;
    if (problem.evaluate(design).attempt.achieved) return design;
  }
  return std::nullopt;
}

class EveryFamily : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Builtin, EveryFamily,
                         ::testing::Values("breakeven/short", "breakeven/two_goals", "breakeven/three_goals",
                                           "breakeven/clutter", "seed/fixed", "seed/random_obstacles"),
                         [](const auto& family) {
                           std::string name{family.param};
                           std::replace(name.begin(), name.end(), '/', '_');
                           return name;
                         });

// The search's postures are the clearest ones, those of a path may be others: a file that holds both has to agree with
// itself, and with whoever reads it.
TEST_P(EveryFamily, GivesSolutionsThatAreReadAndVerifiedAgain) {
  const ProblemFile file = load_problem_file(GetParam());
  const test::TemporaryFolder folder;
  Rng rng{17};
  int verified = 0;
  for (std::uint64_t i = 0; i < 4; ++i) {
    const Instance instance{7, i};
    const auto problem = file.instance(instance);
    const std::optional<Design> design = drawn(*problem, rng);
    if (!design) continue;
    SolutionRecord record;
    record.problem = GetParam();
    if (file.sampled()) record.instance = instance;
    record.design = *design;
    record.X_WB = problem->base_pose(*design);
    const Evaluation found = problem->evaluate(*design);
    const Verification first =
        verify(*problem, *design, {.score = found.score, .achieved = true, .postures = found.attempt.postures});
    record.evaluation = with_path(found, first);
    record.verified = first.level;
    const std::filesystem::path path = folder.path() / (std::to_string(i) + ".json");
    write_solution(path, *problem, record);

    const LoadedSolution loaded = load_solution(path);
    const Attempt& attempt = loaded.record.evaluation.attempt;
    EXPECT_EQ(attempt.path.has_value(), first.path.has_value());
    for (std::size_t g = 0; attempt.path && g < attempt.goal_waypoints.size(); ++g) {
      EXPECT_EQ(attempt.path->waypoints.row(attempt.goal_waypoints[g]),
                attempt.postures.row(static_cast<Eigen::Index>(g)));
    }
    EXPECT_EQ(load_witness(path).postures, attempt.postures);
    const Verification again = verify(*loaded.problem, loaded.record.design,
                                      {.score = loaded.record.evaluation.score,
                                       .reached = attempt.reached,
                                       .achieved = attempt.achieved,
                                       .goal_error = attempt.goal_error,
                                       .clearance = attempt.clearance,
                                       .postures = attempt.postures,
                                       .path = attempt.path});
    EXPECT_EQ(again.verified, first.verified) << (again.findings.empty() ? "" : again.findings.front());
    EXPECT_EQ(again.level, first.level);
    if (first.verified) ++verified;
  }
  EXPECT_GE(verified, 2);
}

}  // namespace
}  // namespace modsearch
