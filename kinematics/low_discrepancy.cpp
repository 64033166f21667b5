#include <modsearch/kinematics/low_discrepancy.hpp>

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace modsearch {
namespace {

std::vector<int> first_primes(int count) {
  std::vector<int> primes;
  for (int candidate = 2; static_cast<int>(primes.size()) < count; ++candidate) {
    bool prime = true;
    for (const int p : primes) {
      if (p * p > candidate) break;
      if (candidate % p == 0) {
        prime = false;
        break;
      }
    }
    if (prime) primes.push_back(candidate);
  }
  return primes;
}

// Digits of `index` in `base`, mirrored at the point.
double radical_inverse(int index, int base) {
  double result = 0.0;
  double weight = 1.0 / base;
  for (int rest = index; rest > 0; rest /= base) {
    result += weight * (rest % base);
    weight /= base;
  }
  return result;
}

}  // namespace

Eigen::VectorXd halton(int index, int dimension) {
  constexpr int kMaxDimension = 256;
  if (dimension < 0 || dimension > kMaxDimension || index < 0) {
    throw std::invalid_argument(fmt::format("halton: index {} or dimension {} out of range", index, dimension));
  }
  static const std::vector<int> primes = first_primes(kMaxDimension);
  Eigen::VectorXd point(dimension);
  for (int i = 0; i < dimension; ++i) {
    const double shifted = radical_inverse(index, primes[static_cast<std::size_t>(i)]) + 0.5;
    point[i] = shifted - std::floor(shifted);
  }
  return point;
}

}  // namespace modsearch
