#include <fmt/format.h>

#include <cmath>
#include <modsearch/kinematics/shape.hpp>
#include <stdexcept>
#include <string>

namespace modsearch {
namespace {

void require_length(double value, const char* shape, const char* what) {
  if (std::isfinite(value) && value >= 0.0) return;
  throw std::invalid_argument(fmt::format("{}: {} must be finite and >= 0 m, is {:.6f}", shape, what, value));
}

void check_one(const Sphere& sphere) { require_length(sphere.radius, "sphere", "radius"); }

void check_one(const Box& box) {
  const char* const names[] = {"size x", "size y", "size z"};
  for (int i = 0; i < 3; ++i) require_length(box.size[i], "box", names[i]);
}

void check_one(const Cylinder& cylinder) {
  require_length(cylinder.radius, "cylinder", "radius");
  require_length(cylinder.length, "cylinder", "length");
}

void check_one(const Capsule& capsule) {
  require_length(capsule.radius, "capsule", "radius");
  require_length(capsule.length, "capsule", "length");
}

void check_one(const Mesh& mesh) {
  if (!mesh.triangles) throw std::invalid_argument("mesh: no triangles given (null pointer)");
  const TriangleMesh& triangles = *mesh.triangles;
  const std::string name = triangles.source.empty() ? "mesh" : "mesh '" + triangles.source + "'";
  if (triangles.triangles.empty()) throw std::invalid_argument(name + ": has no triangle");
  for (std::size_t i = 0; i < triangles.vertices.size(); ++i) {
    if (!triangles.vertices[i].allFinite()) {
      throw std::invalid_argument(name + ": vertex " + std::to_string(i) + " is not finite");
    }
  }
  const auto n_vertices = static_cast<long long>(triangles.vertices.size());
  for (std::size_t i = 0; i < triangles.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int vertex = triangles.triangles[i][k];
      if (vertex >= 0 && vertex < n_vertices) continue;
      throw std::invalid_argument(name + ": triangle " + std::to_string(i) + " names vertex " + std::to_string(vertex) +
                                  " of " + std::to_string(n_vertices));
    }
  }
}

double radius_of(const Sphere& sphere) { return sphere.radius; }
double radius_of(const Box& box) { return 0.5 * box.size.norm(); }
double radius_of(const Cylinder& cylinder) { return std::hypot(cylinder.radius, 0.5 * cylinder.length); }
double radius_of(const Capsule& capsule) { return capsule.radius + 0.5 * capsule.length; }

double radius_of(const Mesh& mesh) {
  if (!mesh.triangles) throw std::invalid_argument("mesh: no triangles given (null pointer)");
  double squared = 0.0;
  for (const Eigen::Vector3d& vertex : mesh.triangles->vertices) squared = std::max(squared, vertex.squaredNorm());
  return std::sqrt(squared);
}

}  // namespace

void check(const Shape& shape) {
  std::visit([](const auto& one) { check_one(one); }, shape);
}

double bounding_radius(const Shape& shape) {
  return std::visit([](const auto& one) { return radius_of(one); }, shape);
}

}  // namespace modsearch
