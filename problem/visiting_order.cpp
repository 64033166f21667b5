#include <algorithm>
#include <cstdint>
#include <limits>
#include <modsearch/problem/visiting_order_internal.hpp>
#include <stdexcept>

namespace modsearch::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMostExact = 12;

struct Ways {
  const Eigen::VectorXd& first;
  const Eigen::MatrixXd& ways;
  const std::vector<std::pair<int, int>>& before;

  [[nodiscard]] int n() const { return static_cast<int>(first.size()); }
  [[nodiscard]] double length(const std::vector<int>& order) const {
    double sum = order.empty() ? 0.0 : first[order.front()];
    for (std::size_t i = 1; i < order.size(); ++i) sum += ways(order[i - 1], order[i]);
    return sum;
  }
  [[nodiscard]] bool allows(const std::vector<int>& order) const {
    return std::all_of(before.begin(), before.end(), [&](const auto& pair) {
      return std::find(order.begin(), order.end(), pair.first) < std::find(order.begin(), order.end(), pair.second);
    });
  }
};

// least(S, j): length of the shortest way from j through all of S, which holds what is left after j.
std::vector<int> exact(const Ways& given) {
  const int n = given.n();
  const auto all = (std::uint32_t{1} << n) - 1;
  std::vector<std::uint32_t> needs(static_cast<std::size_t>(n), 0);  // what has to come before each
  for (const auto& [a, b] : given.before) needs[static_cast<std::size_t>(b)] |= std::uint32_t{1} << a;
  std::vector<double> least((std::size_t{all} + 1) * static_cast<std::size_t>(n), kInfinity);
  const auto at = [&](std::uint32_t left, int j) -> double& {
    return least[std::size_t{left} * static_cast<std::size_t>(n) + static_cast<std::size_t>(j)];
  };
  // Whether k may be next when `left` (k among them) is left.
  const auto may = [&](std::uint32_t left, int k) {
    return (left >> k & 1U) != 0 && (needs[static_cast<std::size_t>(k)] & left) == 0;
  };
  for (std::uint32_t left = 0; left <= all; ++left) {
    for (int j = 0; j < n; ++j) {
      if ((left >> j & 1U) != 0) continue;
      if (left == 0) at(left, j) = 0.0;
      for (int k = 0; k < n; ++k) {
        if (!may(left, k)) continue;
        at(left, j) = std::min(at(left, j), given.ways(j, k) + at(left & ~(std::uint32_t{1} << k), k));
      }
    }
  }
  std::vector<int> order;
  std::uint32_t left = all;
  while (left != 0) {
    int best = -1;
    double shortest = kInfinity;
    for (int k = 0; k < n; ++k) {
      if (!may(left, k)) continue;
      const double way =
          (order.empty() ? given.first[k] : given.ways(order.back(), k)) + at(left & ~(std::uint32_t{1} << k), k);
      if (way < shortest) {
        shortest = way;
        best = k;
      }
    }
    if (best < 0) throw std::invalid_argument("visiting order: no order has everything behind what it needs");
    order.push_back(best);
    left &= ~(std::uint32_t{1} << best);
  }
  return order;
}

std::vector<int> improved(const Ways& given) {
  const int n = given.n();
  std::vector<int> order;
  std::vector<bool> done(static_cast<std::size_t>(n), false);
  while (static_cast<int>(order.size()) < n) {
    int best = -1;
    double shortest = kInfinity;
    for (int k = 0; k < n; ++k) {
      const bool ready = std::all_of(given.before.begin(), given.before.end(), [&](const auto& pair) {
        return pair.second != k || done[static_cast<std::size_t>(pair.first)];
      });
      if (done[static_cast<std::size_t>(k)] || !ready) continue;
      const double way = order.empty() ? given.first[k] : given.ways(order.back(), k);
      if (way < shortest) {
        shortest = way;
        best = k;
      }
    }
    if (best < 0) throw std::invalid_argument("visiting order: no order has everything behind what it needs");
    done[static_cast<std::size_t>(best)] = true;
    order.push_back(best);
  }
  constexpr double kRounding = 1e-12;
  for (bool better = true; better;) {
    better = false;
    for (int from = 0; from < n && !better; ++from) {
      for (int to = 0; to < n && !better; ++to) {
        std::vector<int> moved = order;
        moved.erase(moved.begin() + from);
        moved.insert(moved.begin() + to, order[static_cast<std::size_t>(from)]);
        if (given.length(moved) < given.length(order) - kRounding && given.allows(moved)) {
          order = std::move(moved);
          better = true;
        }
      }
    }
  }
  return order;
}

}  // namespace

std::vector<int> visiting_order(const Eigen::VectorXd& first, const Eigen::MatrixXd& ways,
                                const std::vector<std::pair<int, int>>& before) {
  const Ways given{first, ways, before};
  return given.n() <= kMostExact ? exact(given) : improved(given);
}

}  // namespace modsearch::detail
