#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

Eigen::Vector3d target(const ProblemFile& file, std::uint64_t seed, std::uint64_t index) {
  return file.instance({seed, index})->task().goals()[0].position();
}

TEST(Instance, IsTheSameWheneverItIsAskedFor) {
  const ProblemFile file = load_problem_file("seed/random_obstacles");
  for (std::uint64_t i = 0; i < 50; ++i)
    EXPECT_EQ(target(file, 3, i), target(load_problem_file("seed/random_obstacles"), 3, i));
}

TEST(Instance, ChangesWithSeedAndIndex) {
  const ProblemFile file = load_problem_file("seed/random_wide");
  std::set<double> seen;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    for (std::uint64_t index = 0; index < 100; ++index) seen.insert(target(file, seed, index).x());
  }
  EXPECT_EQ(seen.size(), 1000U);
}

// Drawn once and for all: the numbers of the stream are published ones (rng_test), and the point is
// lower + (upper - lower) * (three of them in turn).
TEST(Instance, FollowsFromTheStreamOfItsSeedAndIndex) {
  const ProblemFile file = load_problem_file("seed/random_narrow");
  Rng rng = Rng{42}.fork("instance").fork(std::uint64_t{7});
  const double x = rng.uniform();
  const double y = rng.uniform();
  const double z = 1.0 + (1.6 - 1.0) * rng.uniform();
  EXPECT_EQ(target(file, 42, 7), (Eigen::Vector3d{x, y, z}));
}

TEST(Instance, FillsItsBoxEvenly) {
  const ProblemFile file = load_problem_file("seed/random_wide");
  constexpr int kDraws = 4000;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int octant = 0;
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d p = target(file, 1, i);
    EXPECT_TRUE((p.array() >= 0.0).all() && p.x() < 1.0 && p.y() < 1.0 && p.z() < 2.0);
    sum += p;
    if (p.x() < 0.5 && p.y() < 0.5 && p.z() < 1.0) ++octant;
  }
  // Standard errors: 0.289 / sqrt(4000) = 0.0046 per unit, and sqrt(4000 / 8 * 7 / 8) = 21 draws. Five of each.
  const Eigen::Vector3d mean = sum / kDraws;
  EXPECT_NEAR(mean.x(), 0.5, 0.023);
  EXPECT_NEAR(mean.y(), 0.5, 0.023);
  EXPECT_NEAR(mean.z(), 1.0, 0.046);
  EXPECT_NEAR(octant, kDraws / 8, 105);
}

TEST(Instance, KeepsItsTargetAwayFromObstacles) {
  const ProblemFile file = load_problem_file("seed/random_obstacles");
  int near = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const double clearance = file.spec.scene->clearance(target(file, 5, i));
    EXPECT_GE(clearance, 0.055);
    if (clearance < 0.1) ++near;
  }
  EXPECT_GT(near, 0);  // and does not stay farther away than it has to
}

TEST(Instance, OfAProblemWithoutSamplingIsTheProblem) {
  const ProblemFile file = load_problem_file("seed/fixed");
  EXPECT_EQ(target(file, 1, 2), (Eigen::Vector3d{1.0, 0.0, 1.0}));
}

TEST(Instance, IsRefusedWhereTheObstaclesFillTheBox) {
  const test::TemporaryFolder folder;
  nlohmann::json problem = nlohmann::json::parse(
      test::text_of(test::source_folder() / "data/scenarios/seed_random_obstacles.json"));
  problem["sampling"]["minClearance"] = 50.0;
  const ProblemFile file = load_problem_file(folder.write("full.json", problem.dump()).string());
  EXPECT_THROW(static_cast<void>(file.instance({0, 0})), std::runtime_error);
}

TEST(Instance, MovesOnlyTheSampledGoalAndKeepsItsTolerances) {
  const ProblemFile file = load_problem_file("seed/random_wide");
  const auto problem = file.instance({0, 0});
  ASSERT_EQ(problem->task().goals().size(), 1U);
  EXPECT_EQ(problem->task().goals()[0].region.tolerances()[0].upper, 0.001);
  EXPECT_EQ(problem->task().name(), "seed/random_wide");
}

}  // namespace
}  // namespace modsearch
