#pragma once

// Signed distance of two bodies that are sums of segments and disks: box (three segments), cylinder (segment and disk),
// segment and point. All are symmetric about their centres, so the signed distance is
//
//   max over unit n of  phi(n) = n.c - sum_i half_i |n.g_i| - sum_j radius_j |n - (n.a_j) a_j|,
//
// where c is the vector between the centres. Every n gives a lower bound: moving A by (d - phi(n)) n leaves a gap of at
// least d in the direction n. The maximum lies where phi is smooth, where n is at right angles to one or two segments,
// or along the axis of a disk; each of these families is searched on its own.

#include <Eigen/Core>
#include <array>

namespace modsearch::detail {

/// The difference A - B of two bodies as one sum of segments and disks about the centre `c`.
struct Difference {
  static constexpr int kMaxSegments = 6;
  static constexpr int kMaxDisks = 2;
  static constexpr int kMaxTriangles = 2;

  Eigen::Vector3d c = Eigen::Vector3d::Zero();          ///< centre of A minus centre of B [m]
  int n_segments = 0;                                   ///< used entries of the next three
  std::array<Eigen::Vector3d, kMaxSegments> direction;  ///< unit vectors
  std::array<double, kMaxSegments> half;                ///< half lengths [m]
  std::array<bool, kMaxSegments> segment_of_a;          ///< belongs to A, not to B
  int n_disks = 0;                                      ///< used entries of the next three
  std::array<Eigen::Vector3d, kMaxDisks> axis;          ///< unit normals
  std::array<double, kMaxDisks> radius;                 ///< [m]
  std::array<bool, kMaxDisks> disk_of_a;                ///< belongs to A, not to B

  /// Triangles, corners relative to the centre of their body. No symmetry: only for `Descent` and `separation_along`.
  int n_triangles = 0;
  std::array<std::array<Eigen::Vector3d, 3>, kMaxTriangles> corners;
  std::array<bool, kMaxTriangles> triangle_of_a;

  void add_segment(const Eigen::Vector3d& unit, double half_length, bool of_a);
  void add_disk(const Eigen::Vector3d& unit_normal, double disk_radius, bool of_a);
  void add_triangle(const std::array<Eigen::Vector3d, 3>& triangle, bool of_a);
  /// Upper bound of the size of everything in play [m]; tolerances are relative to it.
  [[nodiscard]] double scale() const;
};

/// Signed distance of A and B, where they are nearest, and how far the answer is proven.
struct DifferenceResult {
  double distance = 0.0;                              ///< phi(normal), a lower bound of the signed distance [m]
  double upper = 0.0;                                 ///< an upper bound; if negative `distance`, equal to it
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, from B to A
  Eigen::Vector3d on_a = Eigen::Vector3d::Zero();     ///< witness point relative to the centre of A, world axes [m]
  Eigen::Vector3d on_b = Eigen::Vector3d::Zero();     ///< witness point relative to the centre of B, world axes [m]
};

/// Signed distance. `guess` is a direction from B to A to start from; it changes the time, not the answer.
/// Separated bodies: Gilbert, Johnson and Keerthi's descent, until the family of the normal is settled, then Newton
/// steps within the family; `distance` and `upper` agree to about 1e-12 of the size. Overlapping bodies: the best of
/// all families; for two cylinders rim against rim is searched from samples.
[[nodiscard]] DifferenceResult signed_difference(const Difference& d, const Eigen::Vector3d& guess);

/// Whether the distance is negative; stops at the first proof.
[[nodiscard]] bool difference_overlaps(const Difference& d, const Eigen::Vector3d& guess);

/// phi(n) for a unit vector n [m].
[[nodiscard]] double separation_along(const Difference& d, const Eigen::Vector3d& n);

}  // namespace modsearch::detail
