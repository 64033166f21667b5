#include "arrays.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace modsearch::python {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

Numbers numbers(nb::handle array_like) {
  // A plain array of doubles, which is the common case, needs no detour.
  Numbers direct;
  if (nb::try_cast(array_like, direct, false)) return direct;
  const nb::object array = nb::module_::import_("numpy").attr("ascontiguousarray")(array_like, "float64");
  return nb::cast<Numbers>(array);
}

Array<double> to_array(const Eigen::MatrixXd& matrix) {
  const auto rows = static_cast<std::size_t>(matrix.rows());
  const auto cols = static_cast<std::size_t>(matrix.cols());
  Array<double> array = new_array<double>({rows, cols});
  Eigen::Map<RowMajor>(array.data(), matrix.rows(), matrix.cols()) = matrix;
  return array;
}

Array<double> to_array(const Eigen::VectorXd& vector) {
  return to_array(std::span{vector.data(), static_cast<std::size_t>(vector.size())});
}

Array<double> to_array(std::span<const double> values) {
  Array<double> array = new_array<double>({values.size()});
  std::copy(values.begin(), values.end(), array.data());
  return array;
}

Array<double> to_array(const Eigen::Isometry3d& X) {
  Array<double> array = new_array<double>({4, 4});
  write_pose(X, array.data());
  return array;
}

void write_pose(const Eigen::Isometry3d& X, double* out) {
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>{out} = X.matrix();
}

Eigen::VectorXd to_vector(nb::handle array_like, const char* what) {
  const Numbers array = numbers(array_like);
  if (array.ndim() != 1) {
    throw std::invalid_argument(
        fmt::format("{}: a vector is needed, not an array of {} dimensions", what, array.ndim()));
  }
  return Eigen::Map<const Eigen::VectorXd>(array.data(), static_cast<Eigen::Index>(array.shape(0)));
}

Eigen::MatrixXd to_matrix(nb::handle array_like, const char* what) {
  const Numbers array = numbers(array_like);
  if (array.ndim() != 1 && array.ndim() != 2) {
    throw std::invalid_argument(
        fmt::format("{}: a matrix is needed, not an array of {} dimensions", what, array.ndim()));
  }
  const auto rows = static_cast<Eigen::Index>(array.ndim() == 1 ? 1 : array.shape(0));
  const auto cols = static_cast<Eigen::Index>(array.shape(array.ndim() - 1));
  return Eigen::Map<const RowMajor>(array.data(), rows, cols);
}

Eigen::Isometry3d to_pose(const Numbers& matrix, const char* what) {
  if (matrix.ndim() != 2 || matrix.shape(0) != 4 || matrix.shape(1) != 4) {
    throw std::invalid_argument(fmt::format("{}: a pose is a homogeneous matrix [4, 4]", what));
  }
  Eigen::Isometry3d X;
  X.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>{matrix.data()};
  constexpr double kSlack = 1e-6;  // as in files
  const Eigen::Matrix3d R = X.linear();
  const bool rotation =
      (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kSlack && R.determinant() > 0.0;
  const bool affine = X.matrix().row(3) == Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0);
  if (!X.matrix().allFinite() || !rotation || !affine) {
    throw std::invalid_argument(
        fmt::format("{}: the matrix is no pose: a rotation within 1e-6, a finite translation, last row 0 0 0 1", what));
  }
  return X;
}

}  // namespace modsearch::python
