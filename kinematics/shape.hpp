#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace modsearch {

/// Ball of `radius` [m] about the origin of its frame.
struct Sphere {
  double radius = 0.0;
};

/// Cuboid centred at the origin of its frame, edges along the axes; `size` [3] holds the full edge lengths [m].
struct Box {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
};

/// Solid cylinder centred at the origin of its frame, axis along z; `length` is the full height [m], the ends are flat.
struct Cylinder {
  double radius = 0.0;
  double length = 0.0;
};

/// All points within `radius` [m] of a segment of `length` [m] centred at the origin along z: the caps stick out.
struct Capsule {
  double radius = 0.0;
  double length = 0.0;
};

/// Triangle soup in the frame of the shape. Shared, because meshes are large and never change.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;   ///< [m]
  std::vector<Eigen::Vector3i> triangles;  ///< indices into `vertices`
  std::string source;                      ///< file it came from, for messages, pages and files that refer to it
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  ///< by which the numbers of that file were multiplied
};

/// A mesh as a shape. It is a surface: something wholly inside a closed mesh does not touch it.
struct Mesh {
  std::shared_ptr<const TriangleMesh> triangles;
};

/// A solid (or surface, for Mesh) in a frame of its own.
using Shape = std::variant<Sphere, Box, Cylinder, Capsule, Mesh>;

/// A shape with the pose of its frame G in some frame F.
struct PlacedShape {
  Shape shape;
  Eigen::Isometry3d X_FG = Eigen::Isometry3d::Identity();
};

/// Throws std::invalid_argument, naming the shape, the number and its limit, if a size is negative or not finite, or if
/// a mesh is missing, empty, not finite or names a vertex that it does not have. Distances take checked shapes for
/// granted.
void check(const Shape& shape);

/// Radius of the smallest ball about the shape's origin that holds the whole shape [m].
/// Throws std::invalid_argument for a mesh without triangles.
[[nodiscard]] double bounding_radius(const Shape& shape);

}  // namespace modsearch
