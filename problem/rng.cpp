#include <modsearch/problem/rng.hpp>

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace modsearch {
namespace {

std::array<std::uint32_t, 2> halves(std::uint64_t word) {
  return {static_cast<std::uint32_t>(word), static_cast<std::uint32_t>(word >> 32)};
}

// FNV-1a (Fowler, Noll, Vo): only has to tell labels apart; Philox does the mixing.
std::uint64_t fnv1a(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return hash;
}

// Draws use counters whose last word is 0; keys of forks come from counters whose last word says what kind of fork.
constexpr std::uint32_t kLabelFork = 1;
constexpr std::uint32_t kIndexFork = 2;

std::uint64_t forked_key(std::uint64_t key, std::uint64_t name, std::uint32_t kind) {
  const auto [low, high] = halves(name);
  const auto block = philox4x32({low, high, 0, kind}, halves(key));
  return block[0] | (static_cast<std::uint64_t>(block[1]) << 32);
}

}  // namespace

std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key) {
  constexpr std::uint64_t kMultiplier0 = 0xD2511F53;
  constexpr std::uint64_t kMultiplier1 = 0xCD9E8D57;
  constexpr std::uint32_t kWeyl0 = 0x9E3779B9;  // golden ratio
  constexpr std::uint32_t kWeyl1 = 0xBB67AE85;  // sqrt(3) - 1
  for (int round = 0; round < 10; ++round) {
    const auto [low0, high0] = halves(kMultiplier0 * counter[0]);
    const auto [low1, high1] = halves(kMultiplier1 * counter[2]);
    counter = {high1 ^ counter[1] ^ key[0], low1, high0 ^ counter[3] ^ key[1], low0};
    key[0] += kWeyl0;
    key[1] += kWeyl1;
  }
  return counter;
}

Rng::Rng(std::uint64_t seed) : key_{seed} {}

Rng Rng::fork(std::string_view label) const { return Rng{forked_key(key_, fnv1a(label), kLabelFork)}; }

Rng Rng::fork(std::uint64_t index) const { return Rng{forked_key(key_, index, kIndexFork)}; }

std::uint64_t Rng::bits() {
  const auto [low, high] = halves(counter_++);
  const auto block = philox4x32({low, high, 0, 0}, halves(key_));
  return block[0] | (static_cast<std::uint64_t>(block[1]) << 32);
}

double Rng::uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }

double Rng::uniform(double lower, double upper) {
  if (!(lower <= upper) || !std::isfinite(lower) || !std::isfinite(upper)) {
    throw std::invalid_argument(fmt::format("Rng::uniform: [{}, {}) is not a finite interval", lower, upper));
  }
  return lower + (upper - lower) * uniform();
}

int Rng::index(int n) {
  if (n < 1) throw std::invalid_argument(fmt::format("Rng::index: n is {}, at least 1 is needed", n));
  // Rejection keeps it unbiased: accept the largest multiple of n below 2^64.
  const auto count = static_cast<std::uint64_t>(n);
  const std::uint64_t remainder = (~std::uint64_t{0} % count + 1) % count;
  std::uint64_t draw = bits();
  while (draw > ~std::uint64_t{0} - remainder) draw = bits();
  return static_cast<int>(draw % count);
}

double Rng::normal() {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

}  // namespace modsearch
