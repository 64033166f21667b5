#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <modsearch/rl/whitening.hpp>
#include <stdexcept>

namespace modsearch {

Whitening whitening_of(const Eigen::MatrixXd& samples) {
  constexpr double kNarrowest = 1e-5;  // of the widest; samples are floats mostly, which differ by 1e-7 when equal
  if (samples.rows() == 0 || !samples.allFinite()) {
    throw std::invalid_argument(fmt::format("whitening: {} samples, or some that are not finite", samples.rows()));
  }
  Whitening result;
  result.mean = samples.colwise().mean();
  const Eigen::MatrixXd centred = samples.rowwise() - result.mean.transpose();
  const Eigen::MatrixXd covariance = centred.transpose() * centred / static_cast<double>(samples.rows());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes{covariance};  // from the least to the greatest
  const Eigen::VectorXd deviations = axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const double widest = deviations.size() == 0 ? 0.0 : deviations.maxCoeff();
  const Eigen::Index r = (deviations.array() > kNarrowest * widest).count();
  result.A = (axes.eigenvectors().rightCols(r) * deviations.tail(r).cwiseInverse().asDiagonal())
                 .rowwise()
                 .reverse()
                 .transpose();
  return result;
}

std::vector<double> numbers_of(const Whitening& whitening) {
  std::vector<double> numbers{whitening.mean.begin(), whitening.mean.end()};
  for (const auto& row : whitening.A.rowwise()) numbers.insert(numbers.end(), row.begin(), row.end());
  return numbers;
}

Whitening whitening_from(const std::vector<double>& numbers, int n) {
  const auto size = static_cast<Eigen::Index>(numbers.size());
  const Eigen::Index r = n < 1 ? -1 : size / n - 1;
  if (r < 0 || r > n || size != n * (r + 1)) {
    throw std::invalid_argument(fmt::format(
        "whitening: {} numbers, not {} of the mean and as many for each of at most {} directions", size, n, n));
  }
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return {Eigen::Map<const Eigen::VectorXd>{numbers.data(), n}, Eigen::Map<const Rows>{numbers.data() + n, r, n}};
}

}  // namespace modsearch
