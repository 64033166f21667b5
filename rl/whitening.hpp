#pragma once

#include <Eigen/Core>
#include <vector>

namespace modsearch {

/// An affine map v -> A (v - mean) after which samples have mean 0 and covariance 1 (LeCun et al. 1998, "Efficient
/// BackProp", section 4.3). Gradient descent is slow along directions in which inputs hardly differ; the distances of a
/// target from a few points are nearly linear in its place, and what is not is all that tells them apart.
struct Whitening {
  Eigen::VectorXd mean;  ///< [n]
  Eigen::MatrixXd A;     ///< [r x n]; r <= n: directions in which the samples do not differ are left out

  [[nodiscard]] Eigen::VectorXd operator()(const Eigen::VectorXd& v) const { return A * (v - mean); }
};

/// The whitening of `samples` [m x n], one per row, with its directions from the widest to the narrowest. Left out are
/// those whose deviation is below 1e-5 of the widest: rounding, mostly. Throws std::invalid_argument without samples,
/// or for numbers that are not finite.
[[nodiscard]] Whitening whitening_of(const Eigen::MatrixXd& samples);

/// A whitening as a list of numbers, for settings: mean, then A by rows. And back, for inputs of `n` numbers; throws
/// std::invalid_argument unless the list is as long as n (r + 1) for an r in [0, n].
[[nodiscard]] std::vector<double> numbers_of(const Whitening& whitening);
[[nodiscard]] Whitening whitening_from(const std::vector<double>& numbers, int n);

}  // namespace modsearch
