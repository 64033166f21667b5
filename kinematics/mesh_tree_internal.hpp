#pragma once

#include <limits>
#include <modsearch/kinematics/separation.hpp>
#include <modsearch/kinematics/shape.hpp>
#include <vector>

namespace modsearch::detail {

/// Balls around the triangles of a mesh, halved along their longest extent down to single triangles.
class MeshTree {
 public:
  explicit MeshTree(const TriangleMesh& mesh);

  /// Least separation of `a`, which is no mesh, from a triangle of `mesh` at `X_WB`; `mesh` is the one of the
  /// constructor. A ball is a lower bound for the triangles in it, and its distance from any shape is a closed form.
  /// Triangles farther away than `ceiling` are not looked at: where all are, that is the distance and nothing else is
  /// said. The first one at most `floor` away ends the search.
  [[nodiscard]] Separation nearest(const Shape& a, const Eigen::Isometry3d& X_WA, const TriangleMesh& mesh,
                                   const Eigen::Isometry3d& X_WB,
                                   double ceiling = std::numeric_limits<double>::infinity(),
                                   double floor = -std::numeric_limits<double>::infinity()) const;
  /// A distance that `a`, which is no mesh, has at least from every triangle; <= 0: not known to be apart. A few dozen
  /// balls are looked at, those that are nearest: microseconds.
  [[nodiscard]] double least(const Shape& a, const Eigen::Isometry3d& X_WA, const Eigen::Isometry3d& X_WB) const;

 private:
  struct Node {
    Eigen::Vector3d centre;
    double radius;  ///< [m]
    int first;      ///< child nodes first and first + 1, or the triangle if `leaf`
    bool leaf;
  };
  void build(const TriangleMesh& mesh, std::size_t node, std::vector<int>& order, std::size_t begin, std::size_t end);

  std::vector<Node> nodes_;
};

}  // namespace modsearch::detail
