#pragma once

#include <Eigen/Core>
#include <array>

#include "minkowski_internal.hpp"

namespace modsearch::detail {

/// An extreme point of the difference, and which ends of its segments and which rim points make it.
struct Vertex {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  unsigned signs = 0;                                      ///< bit i: segment i adds its positive end
  std::array<Eigen::Vector3d, Difference::kMaxDisks> rim;  ///< unit vectors to the rim points, zero where undecided
  std::array<int, Difference::kMaxTriangles> corner{};     ///< which corner of each triangle
};

/// Up to four extreme points and the weights, summing to 1, of the combination nearest to the origin.
struct Simplex {
  std::array<Vertex, 4> vertex;
  std::array<double, 4> weight{};
  int size = 0;
};

/// The extreme point of the difference that is lowest along the unit vector `n`.
[[nodiscard]] Vertex lowest(const Difference& d, const Eigen::Vector3d& n);

/// Adds the point that `simplex` stands for to witness points on A and B, relative to their centres.
void add_witnesses(const Difference& d, const Simplex& simplex, Eigen::Vector3d& on_a, Eigen::Vector3d& on_b);

/// Descent to the point of the difference nearest to the origin.
///
/// Gilbert, Johnson and Keerthi, "A fast procedure for computing the distance between complex objects in
/// three-dimensional space", 1988, DOI 10.1109/56.2083. Each step adds the extreme point against the present nearest
/// point and drops the points that no longer matter.
class Descent {
 public:
  enum class State {
    kGoing,    ///< another step helps
    kStalled,  ///< no further progress in double precision
    kOverlap,  ///< the origin is inside, or so near that it cannot be told
  };

  Descent(const Difference& d, const Eigen::Vector3d& guess);

  [[nodiscard]] State step();
  [[nodiscard]] double lower() const { return lower_; }                    ///< phi at its best direction so far [m]
  [[nodiscard]] double upper() const { return upper_; }                    ///< distance of the nearest point [m]
  [[nodiscard]] const Eigen::Vector3d& normal() const { return normal_; }  ///< direction of the nearest point
  [[nodiscard]] const Simplex& simplex() const { return simplex_; }        ///< extreme points around the nearest point
  /// The nearest point itself, which is a point of A minus a point of B [m].
  [[nodiscard]] const Eigen::Vector3d& nearest() const { return nearest_; }

 private:
  const Difference& d_;
  Simplex simplex_;
  Eigen::Vector3d nearest_;
  Eigen::Vector3d normal_;
  double lower_;
  double upper_;
  double largest_ = 0.0;  ///< largest squared norm of a vertex [m^2]
  int steps_ = 0;
};

}  // namespace modsearch::detail
