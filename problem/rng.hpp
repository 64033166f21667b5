#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace modsearch {

/// Philox4x32-10: four 32-bit words from a 128-bit counter and a 64-bit key (Salmon et al. 2011, "Parallel random
/// numbers: as easy as 1, 2, 3", SC'11). A pure function, checked against the published vectors.
[[nodiscard]] std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                                      std::array<std::uint32_t, 2> key);

/// A stream of random numbers that is equal on every machine: a counter-based generator with distributions of our own
/// (those of the standard library differ between implementations). A value: copies continue independently alike.
class Rng {
 public:
  explicit Rng(std::uint64_t seed);
  /// An independent stream named by a label or a number, whatever this one has produced so far.
  [[nodiscard]] Rng fork(std::string_view label) const;
  [[nodiscard]] Rng fork(std::uint64_t index) const;

  /// All there is to a stream: a generator made from it goes on with the same numbers. For checkpoints.
  [[nodiscard]] std::array<std::uint64_t, 2> state() const { return {key_, counter_}; }
  explicit Rng(const std::array<std::uint64_t, 2>& state) : key_{state[0]}, counter_{state[1]} {}

  /// 64 uniform bits.
  std::uint64_t bits();
  /// Uniform in [0, 1), a multiple of 2^-53.
  double uniform();
  /// Uniform in [lower, upper). Throws std::invalid_argument unless lower <= upper, both finite.
  double uniform(double lower, double upper);
  /// Uniform in {0, .., n - 1}, without bias. Throws std::invalid_argument if n < 1.
  int index(int n);
  /// Standard normal (Box and Muller 1958, the cosine branch: one number per call).
  double normal();

 private:
  std::uint64_t key_;
  std::uint64_t counter_ = 0;
};

}  // namespace modsearch
