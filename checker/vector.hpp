#pragma once

#include <checker/interval.hpp>
#include <vector>

namespace modsearch_check {

using Numbers = std::array<double, 3>;
using Vector = std::array<Interval, 3>;
using Matrix = std::array<Vector, 3>;  // rows

[[nodiscard]] inline Vector vector_of(const Numbers& a) { return {a[0], a[1], a[2]}; }
[[nodiscard]] inline Numbers middle(const Vector& a) { return {a[0].middle(), a[1].middle(), a[2].middle()}; }

[[nodiscard]] inline Vector operator+(const Vector& a, const Vector& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
[[nodiscard]] inline Vector operator-(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
[[nodiscard]] inline Vector operator-(const Vector& a) { return {-a[0], -a[1], -a[2]}; }
[[nodiscard]] inline Vector operator*(const Interval& s, const Vector& a) { return {s * a[0], s * a[1], s * a[2]}; }
[[nodiscard]] inline Interval dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
[[nodiscard]] inline Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
[[nodiscard]] inline Interval norm(const Vector& a) { return sqrt(square(a[0]) + square(a[1]) + square(a[2])); }
[[nodiscard]] inline bool is_exact(const Vector& a) { return a[0].is_exact() && a[1].is_exact() && a[2].is_exact(); }
[[nodiscard]] inline bool is_zero(const Vector& a) { return a[0].is_zero() && a[1].is_zero() && a[2].is_zero(); }
[[nodiscard]] inline bool same(const Vector& a, const Vector& b) {
  return a[0].same_as(b[0]) && a[1].same_as(b[1]) && a[2].same_as(b[2]);
}
/// The same but for rounding: what is known of both lies within `width`.
[[nodiscard]] inline bool alike(const Interval& a, const Interval& b, double width) {
  const Interval both = hull(a, b);
  return both.upper() - both.lower() <= width;
}
[[nodiscard]] inline bool alike(const Vector& a, const Vector& b, double width) {
  return alike(a[0], b[0], width) && alike(a[1], b[1], width) && alike(a[2], b[2], width);
}
[[nodiscard]] inline Vector hull(const Vector& a, const Vector& b) {
  return {hull(a[0], b[0]), hull(a[1], b[1]), hull(a[2], b[2])};
}
/// On the z axis, without a doubt.
[[nodiscard]] inline bool along_z(const Vector& a) { return a[0].is_zero() && a[1].is_zero(); }

[[nodiscard]] inline Matrix identity() { return {Vector{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}; }
[[nodiscard]] inline Vector column(const Matrix& a, std::size_t k) { return {a[0][k], a[1][k], a[2][k]}; }
[[nodiscard]] inline Matrix transposed(const Matrix& a) { return {column(a, 0), column(a, 1), column(a, 2)}; }
[[nodiscard]] inline Vector operator*(const Matrix& a, const Vector& b) {
  return {dot(a[0], b), dot(a[1], b), dot(a[2], b)};
}
[[nodiscard]] inline Matrix operator*(const Matrix& a, const Matrix& b) {
  Matrix product;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) product[i][k] = dot(a[i], column(b, k));
  }
  return product;
}

/// A vector that is affine in n parameters: offset + sum of x_i columns[i].
struct AffineVector {
  Vector offset{};
  std::vector<Vector> columns;  // [n]

  [[nodiscard]] static AffineVector zero(std::size_t n) { return {Vector{}, std::vector<Vector>(n)}; }
  [[nodiscard]] Vector at(const std::vector<double>& x) const {
    Vector sum = offset;
    for (std::size_t i = 0; i < columns.size(); ++i) sum = sum + Interval{x[i]} * columns[i];
    return sum;
  }
};

[[nodiscard]] inline AffineVector operator+(AffineVector a, const AffineVector& b) {
  a.offset = a.offset + b.offset;
  for (std::size_t i = 0; i < a.columns.size(); ++i) a.columns[i] = a.columns[i] + b.columns[i];
  return a;
}
[[nodiscard]] inline AffineVector operator*(const Interval& s, AffineVector a) {
  a.offset = s * a.offset;
  for (Vector& column : a.columns) column = s * column;
  return a;
}
[[nodiscard]] inline AffineVector operator*(const Matrix& m, AffineVector a) {
  a.offset = m * a.offset;
  for (Vector& column : a.columns) column = m * column;
  return a;
}
[[nodiscard]] inline bool same(const AffineVector& a, const AffineVector& b) {
  bool equal = same(a.offset, b.offset);
  for (std::size_t i = 0; i < a.columns.size(); ++i) equal = equal && same(a.columns[i], b.columns[i]);
  return equal;
}
[[nodiscard]] inline bool is_exact(const AffineVector& a) {
  return is_exact(a.offset) &&
         std::all_of(a.columns.begin(), a.columns.end(), [](const Vector& c) { return is_exact(c); });
}
[[nodiscard]] inline bool along_z(const AffineVector& a) {
  return along_z(a.offset) &&
         std::all_of(a.columns.begin(), a.columns.end(), [](const Vector& c) { return along_z(c); });
}

/// A rigid motion whose rotation is constant and whose translation is affine in the parameters.
struct Pose {
  Matrix turn = identity();
  AffineVector move;
};

[[nodiscard]] inline Pose operator*(const Pose& a, const Pose& b) {
  return {a.turn * b.turn, a.move + a.turn * b.move};
}
[[nodiscard]] inline Pose inverse(const Pose& a) {
  const Matrix back = transposed(a.turn);
  return {back, Interval{-1.0} * (back * a.move)};
}

}  // namespace modsearch_check
