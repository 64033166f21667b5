#include <gtest/gtest.h>

#include <map>
#include <modsearch/baselines/pose_first/sequence_sampler_internal.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/sequence_count.hpp>
#include <set>

#include "baselines/tiny_problems.hpp"

namespace modsearch::detail {
namespace {

TEST(SequenceSampler, DrawsCompleteSequencesOfTheStratumThatWasAskedFor) {
  const std::shared_ptr<const ModuleLibrary> library = load_library("workshop");
  const SequenceSampler sampler{*library, 8};
  Rng rng{1};
  for (const Stratum& stratum : sampler.strata()) {
    for (int i = 0; i < 5; ++i) {
      const std::vector<int> types = sampler.draw(stratum, rng);
      EXPECT_EQ(static_cast<int>(types.size()), stratum.modules);
      EXPECT_EQ(sampler.joints_in(types), stratum.joints);
      EXPECT_TRUE(library->fits_together(types));
      EXPECT_TRUE(library->complete(types));
    }
  }
}

TEST(SequenceSampler, HasAStratumForEveryLengthThatHasSequences) {
  const std::shared_ptr<const ModuleLibrary> library = load_library("workshop");
  const SequenceSampler sampler{*library, 6};
  std::set<int> lengths;
  for (const Stratum& stratum : sampler.strata()) lengths.insert(stratum.modules);
  for (int n = 1; n <= 6; ++n) EXPECT_EQ(lengths.contains(n), count_sequences(*library, n).complete > 0.0) << n;
}

TEST(SequenceSampler, DrawsEverySequenceAsOftenAsItsWeightsSay) {
  // Two blocks in a row, of two types: (0, 0), (0, 1), (1, 0), (1, 1), the last three times as likely as each other
  // one.
  const std::shared_ptr<const ModuleLibrary> library = testing::blocks({false, false});
  SequenceSampler sampler{*library, 2};
  sampler.set_weight(1, 1, 3.0);
  sampler.refresh();
  Rng rng{2};
  std::map<std::vector<int>, int> drawn;
  constexpr int kDraws = 6000;
  for (int i = 0; i < kDraws; ++i) ++drawn[sampler.draw({2, 0}, rng)];
  ASSERT_EQ(drawn.size(), 4u);
  // Four standard deviations of a binomial count of 6000 draws: sqrt(6000 p (1 - p)) is 29 for p = 1/6, 39 for 1/2.
  EXPECT_NEAR(drawn.at({0, 0}), 1000, 120);
  EXPECT_NEAR(drawn.at({0, 1}), 1000, 120);
  EXPECT_NEAR(drawn.at({1, 0}), 1000, 120);
  EXPECT_NEAR(drawn.at({1, 1}), 3000, 160);
}

TEST(SequenceSampler, DrawsNothingWhereTheWeightsLeaveNothing) {
  const std::shared_ptr<const ModuleLibrary> library = testing::blocks({false});
  SequenceSampler sampler{*library, 2};
  sampler.set_weight(-1, 0, 0.0);
  sampler.refresh();
  Rng rng{3};
  EXPECT_TRUE(sampler.draw({2, 0}, rng).empty());
}

}  // namespace
}  // namespace modsearch::detail
