#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/study/signed_rank.hpp>
#include <stdexcept>

#include "study/reference.hpp"

namespace modsearch {
namespace {

TEST(SignedRankTest, AgreesWithSciPy) {
  const nlohmann::json samples = testing::reference("signed_rank");
  for (const auto& [sample, expected] : samples.items()) {
    const SignedRank result = signed_rank_test(expected["differences"].get<std::vector<double>>());
    EXPECT_EQ(result.pairs, expected["pairs"]) << sample;
    EXPECT_EQ(result.exact, expected["exact"]) << sample;
    EXPECT_EQ(result.plus, expected["plus"]) << sample;
    EXPECT_EQ(result.minus, expected["minus"]) << sample;
    EXPECT_NEAR(result.p, expected["p"], 1e-12) << sample;
  }
}

TEST(SignedRankTest, CountsTheSignsOfSixPairs) {
  // All six positive: 2 of the 2^6 choices of signs are as extreme.
  EXPECT_EQ(signed_rank_test(std::vector<double>{1, 2, 3, 4, 5, 6}).p, 2.0 / 64.0);
  EXPECT_EQ(signed_rank_test(std::vector<double>{-1, -2, -3, -4, -5}).p, 2.0 / 32.0);
}

TEST(SignedRankTest, RanksInfiniteDifferencesLast) {
  const SignedRank result = signed_rank_test(std::vector<double>{-1, INFINITY, 2, INFINITY});
  EXPECT_EQ(result.minus, 1.0);
  EXPECT_EQ(result.plus, 2.0 + 3.5 + 3.5);
}

TEST(SignedRankTest, SeesNothingWhereAllPairsAreEqual) {
  const SignedRank result = signed_rank_test(std::vector<double>{0, 0, 0});
  EXPECT_EQ(result.pairs, 0);
  EXPECT_EQ(result.p, 1.0);
  EXPECT_EQ(signed_rank_test({}).p, 1.0);
}

TEST(SignedRankTest, RefusesNaN) {
  EXPECT_THROW((void)signed_rank_test(std::vector<double>{1, NAN}), std::invalid_argument);
}

TEST(HolmAdjusted, AgreesWithStatsmodels) {
  for (const auto& expected : testing::reference("holm")) {
    const std::vector<double> adjusted = holm_adjusted(expected["p"].get<std::vector<double>>());
    ASSERT_EQ(adjusted.size(), expected["adjusted"].size());
    for (std::size_t i = 0; i < adjusted.size(); ++i) EXPECT_NEAR(adjusted[i], expected["adjusted"][i], 1e-12);
  }
}

TEST(HolmAdjusted, RefusesWhatIsNoProbability) {
  EXPECT_THROW((void)holm_adjusted(std::vector<double>{0.1, 1.1}), std::invalid_argument);
  EXPECT_THROW((void)holm_adjusted(std::vector<double>{NAN}), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
