#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <modsearch/problem/rng.hpp>
#include <set>
#include <stdexcept>
#include <vector>

namespace modsearch {
namespace {

using Block = std::array<std::uint32_t, 4>;

// The known answers published with Random123 (Salmon et al. 2011), philox4x32 with ten rounds.
TEST(Philox, GivesThePublishedAnswers) {
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox4x32({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
            (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(Rng, StartsWithTheFirstPhiloxBlockOfItsSeed) {
  Rng rng{0};
  EXPECT_EQ(rng.bits(), 0xe169c58d6627e8d5ULL);
}

TEST(Rng, GivesEqualStreamsForEqualSeedsAndOthersForOthers) {
  Rng a{7}, b{7}, c{8};
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t drawn = a.bits();
    EXPECT_EQ(drawn, b.bits());
    EXPECT_NE(drawn, c.bits());
  }
}

TEST(Rng, ForksDoNotDependOnWhatWasDrawn) {
  Rng used{3};
  for (int i = 0; i < 10; ++i) (void)used.bits();
  EXPECT_EQ(used.fork("starts").bits(), Rng{3}.fork("starts").bits());
  EXPECT_EQ(used.fork(5).bits(), Rng{3}.fork(5).bits());
}

TEST(Rng, ForksAreDistinct) {
  const Rng rng{3};
  std::set<std::uint64_t> seen{Rng{3}.bits()};
  for (std::uint64_t i = 0; i < 1000; ++i) EXPECT_TRUE(seen.insert(rng.fork(i).bits()).second) << i;
  EXPECT_TRUE(seen.insert(rng.fork("a").bits()).second);
  EXPECT_TRUE(seen.insert(rng.fork("b").bits()).second);
}

TEST(Rng, UniformHasTheMomentsOfTheUniformDistribution) {
  Rng rng{1};
  constexpr int kDraws = 100'000;
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double u = rng.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    squares += u * u;
  }
  // Five standard errors: sqrt(1/12/n) and sqrt(4/45/n).
  EXPECT_NEAR(sum / kDraws, 0.5, 5 * std::sqrt(1.0 / 12.0 / kDraws));
  EXPECT_NEAR(squares / kDraws, 1.0 / 3.0, 5 * std::sqrt(4.0 / 45.0 / kDraws));
}

TEST(Rng, NormalHasTheMomentsOfTheNormalDistribution) {
  Rng rng{2};
  constexpr int kDraws = 100'000;
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double z = rng.normal();
    sum += z;
    squares += z * z;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 5 / std::sqrt(kDraws));
  EXPECT_NEAR(squares / kDraws, 1.0, 5 * std::sqrt(2.0 / kDraws));
}

TEST(Rng, IndexIsUniformOverAllValues) {
  Rng rng{4};
  std::vector<int> counts(7, 0);
  constexpr int kDraws = 70'000;
  for (int i = 0; i < kDraws; ++i) ++counts[static_cast<std::size_t>(rng.index(7))];
  for (const int count : counts) EXPECT_NEAR(count, kDraws / 7.0, 5 * std::sqrt(kDraws / 7.0));
}

TEST(Rng, RefusesEmptyRanges) {
  Rng rng{0};
  EXPECT_THROW((void)rng.index(0), std::invalid_argument);
  EXPECT_THROW((void)rng.uniform(1.0, 0.0), std::invalid_argument);
  EXPECT_THROW((void)rng.uniform(0.0, std::numeric_limits<double>::infinity()), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
