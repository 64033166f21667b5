#include <gtest/gtest.h>

#include <modsearch/problem/problem_source.hpp>

namespace modsearch {
namespace {

Eigen::Vector3d target(const ProblemSource& source, std::uint64_t seed) {
  const std::shared_ptr<const DesignProblem> problem = source(Rng{seed});
  return dynamic_cast<const RobotProblem&>(*problem).task().goals()[0].position();
}

TEST(ProblemSource, GivesANewInstanceForEveryStreamAndTheSameForTheSame) {
  const ProblemSource source = problem_source(load_problem_file("seed/random_wide"));
  EXPECT_EQ(target(source, 1), target(source, 1));
  EXPECT_NE(target(source, 1), target(source, 2));
}

TEST(ProblemSource, GivesTheOneProblemOfAFileWithoutSampling) {
  const ProblemSource source = problem_source(load_problem_file("seed/fixed"));
  EXPECT_EQ(source(Rng{1}), source(Rng{2}));
  EXPECT_EQ(target(source, 3), (Eigen::Vector3d{1.0, 0.0, 1.0}));
}

TEST(ProblemSource, GivesTheInstanceThatIsNamed) {
  const ProblemFile file = load_problem_file("seed/random_obstacles");
  const ProblemSource source = problem_source(file, {7, 13});
  EXPECT_EQ(target(source, 1), file.instance({7, 13})->task().goals()[0].position());
  EXPECT_EQ(target(source, 2), target(source, 1));
}

}  // namespace
}  // namespace modsearch
