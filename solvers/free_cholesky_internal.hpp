#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

namespace modsearch {

/// Solves (H + tau I) d = -g for the free variables, the others staying where they are (d = 0). Plain loops on storage
/// that is kept: at 4 to 20 variables they take a fraction of what a general-purpose factorisation does.
///
/// A row of the factor begins where the row of H does, and whatever lies before is passed over (an envelope: George and
/// Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981, chapter 4). The postures of an arm at its
/// goals know each other only through the parameters, which come first among the variables: from the last variable to
/// the first the matrix is an arrow, and the work grows with the number of goals, not with its cube.
class FreeCholesky {
 public:
  explicit FreeCholesky(Eigen::Index n) : factor_(n, n), solution_(n) {}

  /// Factorises the free rows and columns of H (its lower triangle is read) plus tau on the diagonal.
  /// False: not positive definite, or not a number.
  [[nodiscard]] bool factorise(const Eigen::MatrixXd& H, const std::vector<Eigen::Index>& free, double tau) {
    choose_order(H, free);
    const auto k = static_cast<Eigen::Index>(order_.size());
    for (Eigen::Index i = 0; i < k; ++i) {
      for (Eigen::Index j = first(i); j <= i; ++j) factor_(i, j) = entry(H, i, j);
      factor_(i, i) += tau;
    }
    for (Eigen::Index j = 0; j < k; ++j) {
      const double diagonal = factor_(j, j);
      double pivot = diagonal;
      for (Eigen::Index l = first(j); l < j; ++l) pivot -= factor_(j, l) * factor_(j, l);
      // Below the rounding error of the sum the sign of the pivot is chance.
      if (!(pivot > 1e-13 * std::abs(diagonal))) return false;
      const double root = std::sqrt(pivot);
      factor_(j, j) = root;
      for (Eigen::Index i = j + 1; i < k; ++i) {
        if (first(i) > j) continue;
        double sum = factor_(i, j);
        for (Eigen::Index l = std::max(first(i), first(j)); l < j; ++l) sum -= factor_(i, l) * factor_(j, l);
        factor_(i, j) = sum / root;
      }
    }
    return true;
  }

  /// The step d [n] for gradient g [n], after a successful `factorise`.
  void solve(const Eigen::VectorXd& g, Eigen::VectorXd& d) {
    const auto k = static_cast<Eigen::Index>(order_.size());
    d.setZero();
    for (Eigen::Index i = 0; i < k; ++i) {
      double sum = -g[variable(i)];
      for (Eigen::Index l = first(i); l < i; ++l) sum -= factor_(i, l) * solution_[l];
      solution_[i] = sum / factor_(i, i);
    }
    for (Eigen::Index i = k - 1; i >= 0; --i) {
      double sum = solution_[i];
      for (Eigen::Index l = i + 1; l < k; ++l) {
        if (first(l) <= i) sum -= factor_(l, i) * solution_[l];
      }
      solution_[i] = sum / factor_(i, i);
      d[variable(i)] = solution_[i];
    }
  }

 private:
  [[nodiscard]] Eigen::Index variable(Eigen::Index i) const { return order_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] Eigen::Index first(Eigen::Index i) const { return first_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] double entry(const Eigen::MatrixXd& H, Eigen::Index i, Eigen::Index j) const {
    return H(std::max(variable(i), variable(j)), std::min(variable(i), variable(j)));
  }

  // Backwards where that saves at least half of the work.
  void choose_order(const Eigen::MatrixXd& H, const std::vector<Eigen::Index>& free) {
    order_ = free;
    const double forwards = find_first(H);
    std::reverse(order_.begin(), order_.end());
    if (2.0 * find_first(H) <= forwards) return;
    order_ = free;
    (void)find_first(H);
  }

  // Where the rows of H begin in this order; gives the work of a factorisation, in products.
  double find_first(const Eigen::MatrixXd& H) {
    first_.resize(order_.size());
    double work = 0.0;
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(order_.size()); ++i) {
      Eigen::Index begin = 0;
      while (begin < i && entry(H, i, begin) == 0.0) ++begin;
      first_[static_cast<std::size_t>(i)] = begin;
      work += static_cast<double>((i - begin) * (i - begin));
    }
    return work;
  }

  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> factor_;
  Eigen::VectorXd solution_;
  std::vector<Eigen::Index> order_;  // free variables as they are eliminated
  std::vector<Eigen::Index> first_;  // column in which each row of the factor begins
};

}  // namespace modsearch
