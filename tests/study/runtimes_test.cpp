#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/study/runtimes.hpp>
#include <stdexcept>
#include <vector>

#include "study/reference.hpp"

namespace modsearch {
namespace {

TEST(ExpectedRuntime, DividesWhatAllRunsSpentByTheSuccesses) {
  // (100 + 200 + 1000) / 2: the run that failed is paid for by those that did not.
  EXPECT_EQ(expected_runtime(std::vector<TargetRun>{{100, true}, {200, true}, {1000, false}}), 650.0);
}

TEST(ExpectedRuntime, OfRestartsIsWhatTheyNeedOnAverage) {
  // A solver that meets the target after 10 evaluations with probability 1/4 and gives up after 30 else needs
  // 10 + 3 * 30 on average: three failures come before a success.
  std::vector<TargetRun> runs(4000, {30, false});
  for (std::size_t i = 0; i < runs.size(); i += 4) runs[i] = {10, true};
  EXPECT_EQ(expected_runtime(runs), 100.0);
}

TEST(ExpectedRuntime, IsInfiniteWithoutASuccess) {
  EXPECT_EQ(expected_runtime(std::vector<TargetRun>{{100, false}}), INFINITY);
}

TEST(ExpectedRuntime, RefusesNoRunsAndNegativeCosts) {
  EXPECT_THROW((void)expected_runtime({}), std::invalid_argument);
  EXPECT_THROW((void)expected_runtime(std::vector<TargetRun>{{-1, true}}), std::invalid_argument);
}

TEST(SuccessRate, HasWilsonsIntervalAsSciPyComputesIt) {
  for (const auto& expected : testing::reference("wilson")) {
    const Proportion rate = success_rate(expected["successes"], expected["trials"]);
    EXPECT_EQ(rate.value, expected["successes"].get<double>() / expected["trials"].get<double>());
    EXPECT_NEAR(rate.low, expected["interval"][0], 1e-12) << expected;
    EXPECT_NEAR(rate.high, expected["interval"][1], 1e-12) << expected;
  }
}

TEST(SuccessRate, RefusesMoreSuccessesThanTrials) {
  EXPECT_THROW((void)success_rate(3, 2), std::invalid_argument);
  EXPECT_THROW((void)success_rate(0, 0), std::invalid_argument);
  EXPECT_THROW((void)success_rate(-1, 2), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
