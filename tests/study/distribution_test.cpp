#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/study/distribution.hpp>
#include <stdexcept>

#include "study/reference.hpp"

namespace modsearch {
namespace {

TEST(EmpiricalDistribution, StepsAtItsValuesAndEndsBelowOneWhereOneIsInfinite) {
  const StepFunction share = empirical_distribution(std::vector<double>{7.0, 2.0, INFINITY, 2.0});
  EXPECT_EQ(share.at, (std::vector<double>{2.0, 7.0}));
  EXPECT_EQ(share.value, (std::vector<double>{0.5, 0.75}));
  EXPECT_EQ(share(1.999), 0.0);
  EXPECT_EQ(share(2.0), 0.5);
  EXPECT_EQ(share(6.999), 0.5);
  EXPECT_EQ(share(1e300), 0.75);
}

TEST(EmpiricalDistribution, OfNothingButInfiniteValuesIsZero) {
  EXPECT_EQ(empirical_distribution(std::vector<double>{INFINITY})(1e300), 0.0);
}

TEST(EmpiricalDistribution, RefusesNoValueAndNaN) {
  EXPECT_THROW((void)empirical_distribution({}), std::invalid_argument);
  EXPECT_THROW((void)empirical_distribution(std::vector<double>{1.0, NAN}), std::invalid_argument);
  EXPECT_THROW((void)empirical_distribution(std::vector<double>{-INFINITY}), std::invalid_argument);
}

TEST(Quantile, InterpolatesAsNumPyDoes) {
  const std::vector<double> values = testing::reference("first")[0];
  for (const auto& expected : testing::reference("quantiles")) {
    EXPECT_NEAR(quantile(values, expected["p"]), expected["value"], 1e-12) << expected;
  }
}

TEST(Quantile, OfInfiniteNeighboursIsInfinite) {
  EXPECT_EQ(quantile({1.0, INFINITY, INFINITY}, 0.75), INFINITY);
  EXPECT_EQ(quantile({1.0, INFINITY}, 0.5), INFINITY);
  EXPECT_EQ(quantile({1.0, INFINITY}, 0.0), 1.0);
}

TEST(Quantile, RefusesNoValueNaNAndSharesOutsideZeroToOne) {
  EXPECT_THROW((void)quantile({}, 0.5), std::invalid_argument);
  EXPECT_THROW((void)quantile({NAN}, 0.5), std::invalid_argument);
  EXPECT_THROW((void)quantile({1.0}, 1.01), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
