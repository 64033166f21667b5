#include "mesh_tree_internal.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "triangle_internal.hpp"

namespace modsearch::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Triangle triangle_of(const TriangleMesh& mesh, int index) {
  const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(index)];
  const auto vertex = [&](int k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
  return {vertex(0), vertex(1), vertex(2)};
}

}  // namespace

MeshTree::MeshTree(const TriangleMesh& mesh) {
  std::vector<int> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0);
  nodes_.reserve(2 * order.size());
  nodes_.emplace_back();
  build(mesh, 0, order, 0, order.size());
}

void MeshTree::build(const TriangleMesh& mesh, std::size_t node, std::vector<int>& order, std::size_t begin,
                     std::size_t end) {
  Eigen::AlignedBox3d extent;
  for (std::size_t k = begin; k < end; ++k) {
    for (const Vector3d& corner : triangle_of(mesh, order[k])) extent.extend(corner);
  }
  const Vector3d centre = extent.center();
  double squared = 0.0;
  for (std::size_t k = begin; k < end; ++k) {
    for (const Vector3d& corner : triangle_of(mesh, order[k])) {
      squared = std::max(squared, (corner - centre).squaredNorm());
    }
  }
  // A little larger than computed, so that rounding cannot push a corner outside.
  nodes_[node] = {centre, std::sqrt(squared) * (1.0 + 1e-12), order[begin], end - begin == 1};
  if (end - begin == 1) return;
  int axis = 0;
  extent.sizes().maxCoeff(&axis);
  const auto along = [&](int index) {
    const Triangle t = triangle_of(mesh, index);
    return std::pair(t[0][axis] + t[1][axis] + t[2][axis], index);
  };
  const std::size_t middle = begin + (end - begin) / 2;
  std::nth_element(
      order.begin() + static_cast<std::ptrdiff_t>(begin), order.begin() + static_cast<std::ptrdiff_t>(middle),
      order.begin() + static_cast<std::ptrdiff_t>(end), [&](int one, int other) { return along(one) < along(other); });
  const std::size_t children = nodes_.size();
  nodes_[node].first = static_cast<int>(children);
  nodes_.emplace_back();
  nodes_.emplace_back();
  build(mesh, children, order, begin, middle);
  build(mesh, children + 1, order, middle, end);
}

Separation MeshTree::nearest(const Shape& a, const Isometry3d& X_WA, const TriangleMesh& mesh, const Isometry3d& X_WB,
                             double ceiling, double floor) const {
  Separation best;
  best.distance = ceiling;
  Isometry3d X_WN = Isometry3d::Identity();
  const auto bound = [&](std::size_t node) {
    X_WN.translation() = X_WB * nodes_[node].centre;
    return signed_distance(Sphere{nodes_[node].radius}, X_WN, a, X_WA);
  };
  std::vector<std::pair<double, std::size_t>> open{{bound(0), 0}};
  while (!open.empty() && best.distance > floor) {
    const auto [lower, index] = open.back();
    open.pop_back();
    if (lower >= best.distance) continue;
    const Node& node = nodes_[index];
    if (node.leaf) {
      Triangle triangle = triangle_of(mesh, node.first);
      for (Vector3d& corner : triangle) corner = X_WB * corner;
      const Separation s = triangle_separation(a, X_WA, triangle);
      if (s.distance < best.distance) best = s;
      continue;
    }
    const auto child = static_cast<std::size_t>(node.first);
    std::pair<double, std::size_t> near{bound(child), child};
    std::pair<double, std::size_t> far{bound(child + 1), child + 1};
    if (far < near) std::swap(near, far);
    open.push_back(far);
    open.push_back(near);
  }
  return best;
}

double MeshTree::least(const Shape& a, const Isometry3d& X_WA, const Isometry3d& X_WB) const {
  constexpr std::size_t kExpansions = 48;  // arbitrary: balls of a twentieth of the mesh
  using Open = std::pair<double, std::size_t>;
  Isometry3d X_WN = Isometry3d::Identity();
  const auto bound = [&](std::size_t node) {
    X_WN.translation() = X_WB * nodes_[node].centre;
    return signed_distance(Sphere{nodes_[node].radius}, X_WN, a, X_WA);
  };
  std::array<Open, kExpansions + 2> open;
  auto end = open.begin();
  const auto add = [&](std::size_t node) {
    *end++ = {bound(node), node};
    std::push_heap(open.begin(), end, std::greater<>{});
  };
  add(0);
  for (std::size_t i = 0; i < kExpansions; ++i) {
    const Node& nearest = nodes_[open.front().second];
    if (nearest.leaf) break;
    const auto child = static_cast<std::size_t>(nearest.first);
    std::pop_heap(open.begin(), end--, std::greater<>{});
    add(child);
    add(child + 1);
  }
  return open.front().first;
}

}  // namespace modsearch::detail
