#include "fcl_backend_internal.hpp"

#include <fcl/fcl.h>

#include <exception>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>

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

/// Trees of the meshes in use, one per TriangleMesh, dropped after it. Only saves time: a tree depends on nothing but
/// the triangles, which never change.
class TreeCache {
 public:
  std::shared_ptr<const Tree> get(const std::shared_ptr<const TriangleMesh>& mesh) {
    const std::lock_guard lock(mutex_);
    const auto found = trees_.find(mesh.get());
    // An address may be used again by another mesh: the entry counts only while its own mesh lives.
    if (found != trees_.end() && found->second.mesh.lock() == mesh) return found->second.tree;
    std::erase_if(trees_, [](const auto& entry) { return entry.second.mesh.expired(); });
    auto tree = build_tree(*mesh);
    trees_[mesh.get()] = {mesh, tree};
    return tree;
  }

 private:
  struct Entry {
    std::weak_ptr<const TriangleMesh> mesh;
    std::shared_ptr<const Tree> tree;
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
Geometry geometry(const Mesh& mesh) {
  static TreeCache cache;
  return cache.get(mesh.triangles);
}
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

}  // namespace

bool mesh_overlaps(const Shape& a, const Isometry3d& X_WA, const Mesh& b, const Isometry3d& X_WB) {
  return loudly([&] {
    fcl::CollisionRequestd request;
    request.gjk_solver_type = fcl::GST_INDEP;
    fcl::CollisionResultd result;
    return fcl::collide(geometry(a).get(), X_WA, geometry(b).get(), X_WB, request, result) > 0;
  });
}

Separation mesh_separation(const Shape& a, const Isometry3d& X_WA, const Mesh& b, const Isometry3d& X_WB) {
  return loudly([&] {
    fcl::DistanceRequestd request(true);
    request.gjk_solver_type = fcl::GST_INDEP;
    fcl::DistanceResultd result;
    fcl::distance(geometry(a).get(), X_WA, geometry(b).get(), X_WB, request, result);
    Separation s;
    s.distance = result.min_distance;
    s.p_WA = result.nearest_points[0];
    s.p_WB = result.nearest_points[1];
    s.normal_W = (s.p_WA - s.p_WB).normalized();
    return s;
  });
}

}  // namespace modsearch::detail
