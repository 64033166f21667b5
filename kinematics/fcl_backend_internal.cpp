#include "fcl_backend_internal.hpp"

#include <fcl/fcl.h>

#include <exception>
#include <limits>
#include <map>
#include <memory>
#include <modsearch/kinematics/interruption.hpp>
#include <mutex>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "mesh_tree_internal.hpp"
#include "triangle_internal.hpp"

namespace modsearch::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Tree = fcl::BVHModel<fcl::OBBRSSd>;
using Geometry = std::shared_ptr<const fcl::CollisionGeometryd>;

std::shared_ptr<const Tree> build_tree(const TriangleMesh& mesh) {
  auto tree = std::make_shared<Tree>();
  std::vector<fcl::Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                           static_cast<std::size_t>(t[2]));
  }
  tree->beginModel(static_cast<int>(triangles.size()), static_cast<int>(mesh.vertices.size()));
  tree->addSubModel(mesh.vertices, triangles);
  if (tree->endModel() != fcl::BVH_OK) {
    throw std::runtime_error("collision unknown: no bounding volumes for mesh '" + mesh.source + "'");
  }
  tree->computeLocalAABB();
  return tree;
}

/// What a mesh needs beside its triangles.
struct MeshTrees {
  std::shared_ptr<const Tree> boxes;      ///< FCL's, for overlaps and for two meshes
  std::shared_ptr<const MeshTree> balls;  ///< for the distance of a mesh and another shape
};

/// Trees of the meshes in use, one pair per TriangleMesh, dropped after it. Only saves time: a tree depends on nothing
/// but the triangles, which never change.
class TreeCache {
 public:
  MeshTrees get(const std::shared_ptr<const TriangleMesh>& mesh) {
    const std::lock_guard lock(mutex_);
    const auto found = trees_.find(mesh.get());
    // An address may be used again by another mesh: the entry counts only while its own mesh lives.
    if (found != trees_.end() && found->second.mesh.lock() == mesh) return found->second.trees;
    std::erase_if(trees_, [](const auto& entry) { return entry.second.mesh.expired(); });
    MeshTrees trees{build_tree(*mesh), std::make_shared<const MeshTree>(*mesh)};
    trees_[mesh.get()] = {mesh, trees};
    return trees;
  }

 private:
  struct Entry {
    std::weak_ptr<const TriangleMesh> mesh;
    MeshTrees trees;
  };
  std::mutex mutex_;
  std::map<const TriangleMesh*, Entry> trees_;
};

Geometry geometry(const Sphere& sphere) { return std::make_shared<fcl::Sphered>(sphere.radius); }
Geometry geometry(const Box& box) { return std::make_shared<fcl::Boxd>(box.size); }
Geometry geometry(const Cylinder& cylinder) {
  return std::make_shared<fcl::Cylinderd>(cylinder.radius, cylinder.length);
}
Geometry geometry(const Capsule& capsule) { return std::make_shared<fcl::Capsuled>(capsule.radius, capsule.length); }
MeshTrees trees_of(const Mesh& mesh) {
  static TreeCache cache;
  return cache.get(mesh.triangles);
}
Geometry geometry(const Mesh& mesh) { return trees_of(mesh).boxes; }
Geometry geometry(const Shape& shape) {
  return std::visit([](const auto& one) { return geometry(one); }, shape);
}

template <class Query>
auto loudly(const Query& query) {
  try {
    return query();
  } catch (const std::exception& error) {
    throw std::runtime_error(std::string("collision unknown: ") + error.what());
  }
}

Triangle corners(const TriangleMesh& mesh, const Isometry3d& X, std::intptr_t triangle) {
  const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(triangle)];
  const auto corner = [&](int k) -> Vector3d { return X * mesh.vertices[static_cast<std::size_t>(t[k])]; };
  return {corner(0), corner(1), corner(2)};
}

}  // namespace

void prepare(const Shape& shape) {
  if (const Mesh* mesh = std::get_if<Mesh>(&shape)) static_cast<void>(trees_of(*mesh));
}

double least_distance(const Shape& a, const Isometry3d& X_WA, const Shape& b, const Isometry3d& X_WB) {
  constexpr double kRounding = 1e-9;  // [m]
  const Mesh* mesh = std::get_if<Mesh>(&b);
  if (mesh == nullptr) return least_distance(b, X_WB, a, X_WA);
  return trees_of(*mesh).balls->least(a, X_WA, X_WB) - kRounding;
}

bool mesh_overlaps(const Shape& a, const Isometry3d& X_WA, const Mesh& b, const Isometry3d& X_WB) {
  if (!std::holds_alternative<Mesh>(a) && least_distance(a, X_WA, b, X_WB) > 0.0) return false;
  return mesh_touches(a, X_WA, b, X_WB);
}

bool mesh_touches(const Shape& a, const Isometry3d& X_WA, const Shape& b, const Isometry3d& X_WB) {
  return loudly([&] {
    fcl::CollisionRequestd request;
    request.gjk_solver_type = fcl::GST_INDEP;
    fcl::CollisionResultd result;
    return fcl::collide(geometry(b).get(), X_WB, geometry(a).get(), X_WA, request, result) > 0;
  });
}

namespace {

/// Two meshes: FCL finds the triangles that touch or are nearest, measured by `triangle_separation`.
Separation separation_of_meshes(const Mesh& a, const Isometry3d& X_WA, const Mesh& b, const Isometry3d& X_WB) {
  return loudly([&] {
    const Geometry geometry_a = geometry(a);
    const Geometry geometry_b = geometry(b);
    fcl::CollisionRequestd contacts(std::numeric_limits<std::size_t>::max(), true);
    fcl::CollisionResultd touching;
    fcl::collide(geometry_a.get(), X_WA, geometry_b.get(), X_WB, contacts, touching);
    if (touching.isCollision()) {
      Separation deepest;
      deepest.distance = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < touching.numContacts(); ++k) {
        const fcl::Contactd& contact = touching.getContact(k);
        const Separation s =
            triangle_separation(corners(*a.triangles, X_WA, contact.b1), corners(*b.triangles, X_WB, contact.b2));
        if (s.distance < deepest.distance) deepest = s;
      }
      // Edges that just touch may measure as zero, or as a hair more.
      deepest.distance = std::min(deepest.distance, -std::numeric_limits<double>::min());
      return deepest;
    }
    fcl::DistanceRequestd request(true);
    fcl::DistanceResultd nearest;
    fcl::distance(geometry_a.get(), X_WA, geometry_b.get(), X_WB, request, nearest);
    Separation s =
        triangle_separation(corners(*a.triangles, X_WA, nearest.b1), corners(*b.triangles, X_WB, nearest.b2));
    s.distance = std::max(s.distance, 0.0);
    return s;
  });
}

}  // namespace

Separation mesh_separation(const Shape& a, const Isometry3d& X_WA, const Mesh& b, const Isometry3d& X_WB) {
  interruption_point();
  if (const Mesh* mesh = std::get_if<Mesh>(&a)) return separation_of_meshes(*mesh, X_WA, b, X_WB);
  return trees_of(b).balls->nearest(a, X_WA, *b.triangles, X_WB);
}

double distance_within(const Shape& a, const Isometry3d& X_WA, const Shape& b, const Isometry3d& X_WB, double ceiling,
                       double floor) {
  const Mesh* mesh_a = std::get_if<Mesh>(&a);
  const Mesh* mesh_b = std::get_if<Mesh>(&b);
  if ((mesh_a == nullptr) == (mesh_b == nullptr)) return std::min(ceiling, signed_distance(a, X_WA, b, X_WB));
  if (mesh_a != nullptr) return distance_within(b, X_WB, a, X_WA, ceiling, floor);
  return trees_of(*mesh_b).balls->nearest(a, X_WA, *mesh_b->triangles, X_WB, ceiling, floor).distance;
}

}  // namespace modsearch::detail
