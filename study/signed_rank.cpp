#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/study/signed_rank.hpp>
#include <numeric>
#include <stdexcept>

namespace modsearch {
namespace {

// Up to here the counts of the exact distribution, 2^n in all, are whole numbers in a double.
constexpr int kMostExactPairs = 50;

// Two-sided p of a sum of ranks `least`, the smaller of the two, among the 2^n equally likely choices of signs.
double exact_p(int n, double least) {
  // ways[w]: how many subsets of the ranks so far add up to w.
  std::vector<double> ways(static_cast<std::size_t>(n * (n + 1) / 2) + 1, 0.0);
  ways[0] = 1.0;
  for (std::size_t rank = 1; rank <= static_cast<std::size_t>(n); ++rank) {
    for (std::size_t sum = ways.size() - 1; sum >= rank; --sum) ways[sum] += ways[sum - rank];
  }
  const double below = std::accumulate(ways.begin(), ways.begin() + static_cast<std::ptrdiff_t>(least) + 1, 0.0);
  return std::min(1.0, 2.0 * std::ldexp(below, -n));
}

// `tied`: sum of t^3 - t over the groups of t equal sizes.
double normal_p(int n, double least, double tied) {
  const double mean = n * (n + 1.0) / 4.0;
  const double variance = n * (n + 1.0) * (2.0 * n + 1.0) / 24.0 - tied / 48.0;
  const double distance = std::max(0.0, mean - least - 0.5);
  return std::min(1.0, std::erfc(distance / std::sqrt(2.0 * variance)));
}

}  // namespace

SignedRank signed_rank_test(std::span<const double> differences) {
  std::vector<double> sorted;
  for (const double difference : differences) {
    if (std::isnan(difference)) throw std::invalid_argument("signed_rank_test: a difference is NaN");
    if (difference != 0.0) sorted.push_back(difference);
  }
  std::sort(sorted.begin(), sorted.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });

  SignedRank out{.pairs = static_cast<int>(sorted.size())};
  if (sorted.empty()) return out;
  double tied = 0.0;
  for (std::size_t begin = 0, end = 0; begin < sorted.size(); begin = end) {
    while (end < sorted.size() && std::abs(sorted[end]) == std::abs(sorted[begin])) ++end;
    const auto size = static_cast<double>(end - begin);
    const double rank = (static_cast<double>(begin + end) + 1.0) / 2.0;
    tied += size * size * size - size;
    for (std::size_t i = begin; i < end; ++i) (sorted[i] > 0.0 ? out.plus : out.minus) += rank;
  }
  out.exact = tied == 0.0 && out.pairs <= kMostExactPairs;
  const double least = std::min(out.plus, out.minus);
  out.p = out.exact ? exact_p(out.pairs, least) : normal_p(out.pairs, least, tied);
  return out;
}

std::vector<double> holm_adjusted(std::span<const double> p) {
  for (const double value : p) {
    if (!(value >= 0.0 && value <= 1.0)) {
      throw std::invalid_argument(fmt::format("holm_adjusted: a p-value is {}, not in [0, 1]", value));
    }
  }
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p[a] < p[b]; });

  std::vector<double> adjusted(p.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    largest = std::max(largest, std::min(1.0, static_cast<double>(p.size() - i) * p[order[i]]));
    adjusted[order[i]] = largest;
  }
  return adjusted;
}

}  // namespace modsearch
