#pragma once

#include <Eigen/Core>

namespace modsearch {

/// Point `index` (from 0) of the Halton sequence in [0, 1)^dimension, bases the first primes (Halton 1960), each
/// component shifted by a fixed amount so that point 0 is the centre of the cube. Deterministic: used wherever an
/// algorithm needs spread-out points and must stay a function of its input.
/// Throws std::invalid_argument if dimension is not in [0, 256] or index < 0.
[[nodiscard]] Eigen::VectorXd halton(int index, int dimension);

}  // namespace modsearch
