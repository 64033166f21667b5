#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <Eigen/Geometry>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

namespace modsearch::python {

namespace nb = nanobind;

/// A new numpy array in row-major order that owns its numbers.
template <typename Scalar>
using Array = nb::ndarray<nb::numpy, Scalar>;

/// Numbers to be read: float64, row-major.
using Numbers = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;

/// For properties that return such an array: it is not part of the object that it was asked of.
inline constexpr auto kFresh = nb::rv_policy::automatic;

/// An array of `shape` whose numbers are still to be filled in.
template <typename Scalar>
[[nodiscard]] Array<Scalar> new_array(std::initializer_list<std::size_t> shape) {
  std::size_t size = 1;
  for (const std::size_t n : shape) size *= n;
  auto* data = new Scalar[size > 0 ? size : 1];
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<Scalar*>(p); });
  return Array<Scalar>(data, shape.size(), shape.begin(), owner);
}

/// Whatever numpy takes for an array of numbers, as float64. Throws what numpy throws.
[[nodiscard]] Numbers numbers(nb::handle array_like);

[[nodiscard]] Array<double> to_array(const Eigen::MatrixXd& matrix);
[[nodiscard]] Array<double> to_array(const Eigen::VectorXd& vector);
[[nodiscard]] Array<double> to_array(std::span<const double> values);
/// A pose as a homogeneous matrix [4, 4].
[[nodiscard]] Array<double> to_array(const Eigen::Isometry3d& X);
/// Writes the sixteen numbers of a pose, row-major.
void write_pose(const Eigen::Isometry3d& X, double* out);

/// A vector of any length. Throws std::invalid_argument, naming `what`, for an array of another shape.
[[nodiscard]] Eigen::VectorXd to_vector(nb::handle array_like, const char* what);
/// A matrix; a vector stands for a matrix of one row.
[[nodiscard]] Eigen::MatrixXd to_matrix(nb::handle array_like, const char* what);
/// A pose from a homogeneous matrix [4, 4] whose rotation is one within 1e-6.
[[nodiscard]] Eigen::Isometry3d to_pose(const Numbers& matrix, const char* what);

}  // namespace modsearch::python
