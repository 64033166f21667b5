#include <checker/problem.hpp>
#include <cmath>
#include <cstdint>

namespace modsearch_check {
namespace {

using Words = std::array<std::uint32_t, 4>;

/// Philox4x32-10 (Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3", SC'11): two of the four words go
/// through a 32 x 32 -> 64 bit multiplication in each of ten rounds, and the key moves on by two constants.
std::uint64_t philox(Words word, std::uint64_t key) {
  auto key0 = static_cast<std::uint32_t>(key);
  auto key1 = static_cast<std::uint32_t>(key >> 32);
  for (int round = 0; round < 10; ++round, key0 += 0x9E3779B9U, key1 += 0xBB67AE85U) {
    const std::uint64_t a = std::uint64_t{word[0]} * 0xD2511F53U;
    const std::uint64_t b = std::uint64_t{word[2]} * 0xCD9E8D57U;
    word = {static_cast<std::uint32_t>(b >> 32) ^ word[1] ^ key0, static_cast<std::uint32_t>(b),
            static_cast<std::uint32_t>(a >> 32) ^ word[3] ^ key1, static_cast<std::uint32_t>(a)};
  }
  return word[0] | (std::uint64_t{word[1]} << 32);
}

/// The output of key `key` for a 64-bit number; `purpose` 0: the number-th draw, 1: the stream of a label (by its
/// hash), 2: the stream of an index.
std::uint64_t output(std::uint64_t key, std::uint64_t number, std::uint32_t purpose) {
  return philox({static_cast<std::uint32_t>(number), static_cast<std::uint32_t>(number >> 32), 0, purpose}, key);
}

std::uint64_t fnv1a(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

/// Signed distance of a point from an obstacle; a mesh is refused.
double distance(const Shape& shape, const Numbers& point) {
  Numbers local{};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      local[k] += shape.pose.turn[i][k].middle() * (point[i] - shape.pose.move.offset[i].middle());
    }
  }
  const auto size = [&](std::size_t i) { return shape.size[i].offset.middle(); };
  // Of a box (in as many dimensions as there are numbers): outside, the distance; inside, minus that of the next side.
  const auto from_sides = [](std::initializer_list<double> beyond) {
    double squares = 0.0;
    double next = -INFINITY;
    for (const double b : beyond) {
      squares += b > 0.0 ? b * b : 0.0;
      next = std::max(next, b);
    }
    return next > 0.0 ? std::sqrt(squares) : next;
  };
  switch (shape.kind) {
    case Kind::kSphere:
      return std::sqrt(local[0] * local[0] + local[1] * local[1] + local[2] * local[2]) - size(0);
    case Kind::kBox:
      return from_sides(
          {std::abs(local[0]) - 0.5 * size(0), std::abs(local[1]) - 0.5 * size(1), std::abs(local[2]) - 0.5 * size(2)});
    case Kind::kCylinder:
      return from_sides({std::hypot(local[0], local[1]) - size(0), std::abs(local[2]) - 0.5 * size(1)});
    case Kind::kMesh:
      break;
  }
  throw Rejected("nothing is proved about targets drawn among meshes");
}

}  // namespace

Numbers draw_target(const Numbers& lower, const Numbers& upper, double clearance, const Task& task, std::uint64_t seed,
                    std::uint64_t index) {
  const std::uint64_t key = output(output(seed, fnv1a("instance"), 1), index, 2);
  std::uint64_t drawn = 0;
  for (int attempt = 0; attempt < 10'000; ++attempt) {
    Numbers target{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double uniform = static_cast<double>(output(key, drawn++, 0) >> 11) * 0x1p-53;
      target[axis] = lower[axis] + (upper[axis] - lower[axis]) * uniform;
    }
    bool free = true;
    for (const Shape& obstacle : task.obstacles) free = free && !(distance(obstacle, target) < clearance);
    if (free) return target;
  }
  throw Rejected("no target of the instance is far enough from the obstacles");
}

}  // namespace modsearch_check
