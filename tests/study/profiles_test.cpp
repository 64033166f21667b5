#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/study/profiles.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

// Three solvers on four problems; nobody solves the last one.
const RuntimeTable kRuntimes{{10, 40, INFINITY, INFINITY}, {20, 20, 100, INFINITY}, {10, 80, 400, INFINITY}};

TEST(PerformanceProfiles, ShareTheRatiosToTheBestSolverOfEachProblem) {
  // Ratios: first 1, 2, -; second 2, 1, 1; third 1, 4, 4.
  const std::vector<StepFunction> profiles = performance_profiles(kRuntimes);
  EXPECT_EQ(profiles[0].at, (std::vector<double>{1, 2}));
  EXPECT_EQ(profiles[0].value, (std::vector<double>{0.25, 0.5}));
  EXPECT_EQ(profiles[1].at, (std::vector<double>{1, 2}));
  EXPECT_EQ(profiles[1].value, (std::vector<double>{0.5, 0.75}));
  EXPECT_EQ(profiles[2].at, (std::vector<double>{1, 4}));
  EXPECT_EQ(profiles[2].value, (std::vector<double>{0.25, 0.75}));
}

TEST(PerformanceProfiles, CompareRuntimesOfZero) {
  const std::vector<StepFunction> profiles = performance_profiles({{0.0}, {0.0}, {5.0}});
  EXPECT_EQ(profiles[0](1.0), 1.0);
  EXPECT_EQ(profiles[1](1.0), 1.0);
  EXPECT_EQ(profiles[2](1e300), 0.0);
}

TEST(DataProfiles, CountInSimplexGradients) {
  // 10 / (4 + 1), 40 / (9 + 1), ..
  const std::vector<int> dimensions{4, 9, 19, 0};
  const std::vector<StepFunction> profiles = data_profiles(kRuntimes, dimensions);
  EXPECT_EQ(profiles[0].at, (std::vector<double>{2, 4}));
  EXPECT_EQ(profiles[1].at, (std::vector<double>{2, 4, 5}));
  EXPECT_EQ(profiles[2].at, (std::vector<double>{2, 8, 20}));
  EXPECT_EQ(profiles[2].value, (std::vector<double>{0.25, 0.5, 0.75}));
}

TEST(Profiles, RefuseTablesThatAreNotTables) {
  const std::vector<int> two{1, 1};
  EXPECT_THROW((void)performance_profiles({}), std::invalid_argument);
  EXPECT_THROW((void)performance_profiles({{1.0, 2.0}, {1.0}}), std::invalid_argument);
  EXPECT_THROW((void)performance_profiles({{NAN}}), std::invalid_argument);
  EXPECT_THROW((void)data_profiles({{1.0}}, two), std::invalid_argument);
  EXPECT_THROW((void)data_profiles({{1.0, 2.0}}, std::vector<int>{1, -1}), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
