#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <modsearch/problem/files.hpp>
#include <modsearch/rl/elite.hpp>
#include <modsearch/rl/replay.hpp>
#include <modsearch/solvers/archive.hpp>
#include <set>

#include "rl/toy_environments.hpp"

namespace modsearch {
namespace {

Experience numbered(int i) {
  const auto x = static_cast<float>(i);
  Experience e;
  e.s = Eigen::VectorXf::Constant(4, x);
  e.k = i % 3;
  e.memory = Eigen::VectorXf::Constant(3, x + 0.25F);
  e.reward = x + 0.5F;
  e.discount = 0.9F;
  e.remaining = 2.0F * x;
  e.s_next = Eigen::VectorXf::Constant(4, x + 1.0F);
  e.next_mask = 7;
  return e;
}

std::vector<int> sampled(const Replay& replay, int n, std::uint64_t seed) {
  Batch batch;
  batch.resize(n, 4, 3);
  Rng rng{seed};
  replay.sample(rng, 0, n, batch);
  std::vector<int> numbers;
  for (int row = 0; row < n; ++row) {
    const int i = static_cast<int>(batch.s(row, 0));
    EXPECT_EQ(batch.k[row], i % 3);
    EXPECT_EQ(batch.x(row, 2), static_cast<float>(i) + 0.25F);
    EXPECT_EQ(batch.reward[row], static_cast<float>(i) + 0.5F);
    EXPECT_EQ(batch.remaining[row], 2.0F * static_cast<float>(i));
    EXPECT_EQ(batch.s_next(row, 3), static_cast<float>(i) + 1.0F);
    numbers.push_back(i);
  }
  return numbers;
}

TEST(Replay, ForgetsTheOldestWhenItIsFull) {
  Replay replay{5, 4, 3};
  for (int i = 0; i < 12; ++i) replay.add(numbered(i));
  EXPECT_EQ(replay.size(), 5);
  const std::vector<int> numbers = sampled(replay, 400, 0);
  EXPECT_EQ(std::set<int>(numbers.begin(), numbers.end()), (std::set<int>{7, 8, 9, 10, 11}));
}

TEST(Replay, SamplesUniformlyWithReplacement) {
  Replay replay{4, 4, 3};
  for (int i = 0; i < 4; ++i) replay.add(numbered(i));
  std::array<int, 4> counts{};
  for (const int i : sampled(replay, 4000, 1)) ++counts[static_cast<std::size_t>(i)];
  for (const int count : counts) EXPECT_NEAR(count, 1000, 5 * 27.4);  // five deviations of a binomial
}

TEST(Replay, IsRefusedBeforeItHoldsAnything) {
  const Replay replay{4, 4, 3};
  Batch batch;
  batch.resize(1, 4, 3);
  Rng rng{0};
  EXPECT_THROW(replay.sample(rng, 0, 1, batch), std::logic_error);
  EXPECT_THROW((Replay{0, 4, 3}), std::invalid_argument);
}

TEST(Replay, ComesBackFromAnArchiveWithItsOrder) {
  const testing::IdentityEnvironment environment;
  Replay replay{5, 4, 3};
  for (int i = 0; i < 7; ++i) replay.add(numbered(i));
  Archive archive;
  replay.save("replay", archive);
  Replay other{5, 4, 3};
  other.load("replay", archive, environment);
  EXPECT_EQ(sampled(other, 50, 2), sampled(replay, 50, 2));
  replay.add(numbered(7));
  other.add(numbered(7));
  EXPECT_EQ(sampled(other, 50, 3), sampled(replay, 50, 3));
  Replay smaller{4, 4, 3};
  EXPECT_THROW(smaller.load("replay", archive, environment), FileError);
  Replay wider{5, 5, 3};
  EXPECT_THROW(wider.load("replay", archive, environment), FileError);
}

TEST(Elite, KeepsTheBestEpisodesAndComesBackFromAnArchive) {
  const testing::IdentityEnvironment environment;
  Elite elite{2};
  elite.add(1.0, {numbered(1)});
  elite.add(3.0, {numbered(3), numbered(4)});
  elite.add(2.0, {numbered(2)});
  elite.add(0.5, {numbered(5)});
  const auto kept = [](const Elite& e) {
    Batch batch;
    batch.resize(200, 4, 3);
    Rng rng{0};
    e.sample(rng, 0, 200, batch);
    std::vector<float> numbers;
    for (int row = 0; row < 200; ++row) numbers.push_back(batch.s(row, 0));
    return numbers;
  };
  const std::vector<float> numbers = kept(elite);
  EXPECT_EQ(std::set<float>(numbers.begin(), numbers.end()), (std::set<float>{2.0F, 3.0F, 4.0F}));
  Archive archive;
  elite.save("elite", archive);
  Elite other{2};
  other.load("elite", archive, environment, 3);
  EXPECT_EQ(kept(other), numbers);
}

}  // namespace
}  // namespace modsearch
