#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace modsearch {

/// Solves (H + tau I) d = -g for the free variables, the others staying where they are (d = 0). Plain loops on storage
/// that is kept: at 4 to 20 variables they take a fraction of what a general-purpose factorisation does.
class FreeCholesky {
 public:
  explicit FreeCholesky(Eigen::Index n) : factor_(n, n), solution_(n) {}

  /// Factorises the free rows and columns of H (its lower triangle is read) plus tau on the diagonal.
  /// False: not positive definite, or not a number.
  [[nodiscard]] bool factorise(const Eigen::MatrixXd& H, const std::vector<Eigen::Index>& free, double tau) {
    const auto k = static_cast<Eigen::Index>(free.size());
    for (Eigen::Index j = 0; j < k; ++j) {
      const Eigen::Index column = free[static_cast<std::size_t>(j)];
      for (Eigen::Index i = j; i < k; ++i) factor_(i, j) = H(free[static_cast<std::size_t>(i)], column);
      factor_(j, j) += tau;
    }
    for (Eigen::Index j = 0; j < k; ++j) {
      const double diagonal = factor_(j, j);
      double pivot = diagonal;
      for (Eigen::Index l = 0; l < j; ++l) pivot -= factor_(j, l) * factor_(j, l);
      // Below the rounding error of the sum the sign of the pivot is chance.
      if (!(pivot > 1e-13 * std::abs(diagonal))) return false;
      const double root = std::sqrt(pivot);
      factor_(j, j) = root;
      for (Eigen::Index i = j + 1; i < k; ++i) {
        double sum = factor_(i, j);
        for (Eigen::Index l = 0; l < j; ++l) sum -= factor_(i, l) * factor_(j, l);
        factor_(i, j) = sum / root;
      }
    }
    return true;
  }

  /// The step d [n] for gradient g [n], after a successful `factorise` with the same `free`.
  void solve(const Eigen::VectorXd& g, const std::vector<Eigen::Index>& free, Eigen::VectorXd& d) {
    const auto k = static_cast<Eigen::Index>(free.size());
    d.setZero();
    for (Eigen::Index i = 0; i < k; ++i) {
      double sum = -g[free[static_cast<std::size_t>(i)]];
      for (Eigen::Index l = 0; l < i; ++l) sum -= factor_(i, l) * solution_[l];
      solution_[i] = sum / factor_(i, i);
    }
    for (Eigen::Index i = k - 1; i >= 0; --i) {
      double sum = solution_[i];
      for (Eigen::Index l = i + 1; l < k; ++l) sum -= factor_(l, i) * solution_[l];
      solution_[i] = sum / factor_(i, i);
      d[free[static_cast<std::size_t>(i)]] = solution_[i];
    }
  }

 private:
  Eigen::MatrixXd factor_;
  Eigen::VectorXd solution_;
};

}  // namespace modsearch
