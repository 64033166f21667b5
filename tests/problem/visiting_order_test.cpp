#include <gtest/gtest.h>

#include <algorithm>
#include <modsearch/problem/rng.hpp>
#include <modsearch/problem/visiting_order_internal.hpp>
#include <numeric>
#include <stdexcept>

namespace modsearch::detail {
namespace {

struct Ways {
  Eigen::VectorXd first;
  Eigen::MatrixXd between;

  [[nodiscard]] double length(const std::vector<int>& order) const {
    double sum = first[order[0]];
    for (std::size_t i = 1; i < order.size(); ++i) sum += between(order[i - 1], order[i]);
    return sum;
  }
};

Ways random_ways(int n, Rng& rng) {
  Ways ways{Eigen::VectorXd(n), Eigen::MatrixXd(n, n)};
  for (int i = 0; i < n; ++i) {
    ways.first[i] = rng.uniform(0.0, 1.0);
    for (int j = 0; j < n; ++j) ways.between(i, j) = rng.uniform(0.0, 1.0);
  }
  return ways;
}

std::vector<int> numbers(int n) {
  std::vector<int> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

TEST(VisitingOrder, IsTheShortestOfAllThatAreAllowed) {
  Rng rng{3};
  for (int trial = 0; trial < 60; ++trial) {
    const int n = 1 + trial % 7;
    const Ways ways = random_ways(n, rng);
    std::vector<std::pair<int, int>> before;
    if (n > 2 && trial % 2 == 1) before = {{n - 1, 0}, {1, n - 1}};
    const auto allowed = [&](const std::vector<int>& order) {
      return std::all_of(before.begin(), before.end(), [&](const auto& pair) {
        return std::find(order.begin(), order.end(), pair.first) < std::find(order.begin(), order.end(), pair.second);
      });
    };
    double best = 1e9;
    std::vector<int> order = numbers(n);
    do {
      if (allowed(order)) best = std::min(best, ways.length(order));
    } while (std::next_permutation(order.begin(), order.end()));
    const std::vector<int> found = visiting_order(ways.first, ways.between, before);
    EXPECT_TRUE(allowed(found));
    EXPECT_TRUE(std::is_permutation(found.begin(), found.end(), order.begin()));
    EXPECT_NEAR(ways.length(found), best, 1e-12);
  }
}

// Twenty points on a line, given mixed up: from one end to the other is best.
TEST(VisitingOrder, FindsAGoodOneForMany) {
  constexpr int kMany = 20;
  Ways ways{Eigen::VectorXd(kMany), Eigen::MatrixXd(kMany, kMany)};
  const auto place = [](int i) { return (7 * i) % kMany; };
  for (int i = 0; i < kMany; ++i) {
    ways.first[i] = place(i);
    for (int j = 0; j < kMany; ++j) ways.between(i, j) = std::abs(place(i) - place(j));
  }
  const std::vector<int> order = visiting_order(ways.first, ways.between, {});
  EXPECT_EQ(ways.length(order), kMany - 1);
  const std::vector<int> bound = visiting_order(ways.first, ways.between, {{order.back(), order.front()}});
  EXPECT_LT(std::find(bound.begin(), bound.end(), order.back()), std::find(bound.begin(), bound.end(), order.front()));
}

TEST(VisitingOrder, RefusesWhatBitesItsTail) {
  const Ways ways{Eigen::VectorXd::Zero(2), Eigen::MatrixXd::Zero(2, 2)};
  EXPECT_THROW((void)visiting_order(ways.first, ways.between, {{0, 1}, {1, 0}}), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch::detail
