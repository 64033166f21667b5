#pragma once

#include <cstdint>

namespace modsearch {

/// A fixed sequence of well-mixed numbers, a different one per stream: number n is a hash of (stream, n), so that
/// whatever uses it stays a function of its arguments. The hash is the finaliser of SplitMix64 (Steele, Lea and Flood
/// 2014, Fast splittable pseudorandom number generators, doi:10.1145/2660193.2660195).
class FixedStream {
 public:
  explicit FixedStream(std::uint64_t stream) : key_{mixed(stream + kGoldenGamma)} {}

  /// The next number, in [0, 1).
  [[nodiscard]] double next() {
    const std::uint64_t bits = mixed(key_ + kGoldenGamma * ++counter_);
    return static_cast<double>(bits >> 11) * 0x1.0p-53;  // the 53 bits that a double holds
  }

 private:
  static constexpr std::uint64_t kGoldenGamma = 0x9e3779b97f4a7c15;  // odd, 2^64 over the golden ratio

  static std::uint64_t mixed(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }

  std::uint64_t key_;
  std::uint64_t counter_ = 0;
};

}  // namespace modsearch
