#pragma once

#include <cmath>
#include <cstddef>
#include <modsearch/baselines/certify/node_bound_internal.hpp>
#include <vector>

// What the parts of NodeBound share.
namespace modsearch::certify::node_bound {

// Beyond this an angle counts as any angle: as the checker has it.
inline constexpr double kHalfTurn = 3.14;

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }
inline int pair_of(int v, int w) { return w * (w + 1) / 2 + v; }  // v <= w
inline int n_pairs(int acting) { return acting * (acting + 1) / 2; }

// Largest |R b - R' b| / |b| for rotations at most `delta` apart.
inline double greatest_chord(double delta) { return delta >= kHalfTurn ? 2.0 : 2.0 * std::sin(0.5 * delta); }

inline Eigen::Vector3d unit_or_zero(const Eigen::Vector3d& a) {
  const double length = a.norm();
  return length > 0.0 ? Eigen::Vector3d{a / length} : Eigen::Vector3d{Eigen::Vector3d::Zero()};
}

template <typename T>
void grow(std::vector<T>& vector, std::size_t size) {
  if (vector.size() < size) vector.resize(size);
}

}  // namespace modsearch::certify::node_bound
