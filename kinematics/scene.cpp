#include <fmt/format.h>

#include <modsearch/kinematics/scene.hpp>
#include <modsearch/kinematics/self_pairs_internal.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Isometry3d pose_of(const ArmGeometry& geometry, const Posture& posture) {
  return posture.frames[static_cast<std::size_t>(geometry.frame)] * geometry.X_FG;
}

BoundingCapsule capsule_of(const ArmGeometry& geometry, const Eigen::Isometry3d& X_WG) {
  return bounding_capsule(geometry.shape, geometry.bounding_radius, X_WG);
}

void check_pose(const Eigen::Isometry3d& X_WG) {
  if (!X_WG.matrix().allFinite()) throw std::invalid_argument("a number of the pose is not finite");
  // Files carry rotations with six digits or so; distances are wrong by this much at an arm's length.
  constexpr double kTolerance = 1e-5;
  const Eigen::Matrix3d& R = X_WG.linear();
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > kTolerance || R.determinant() < 0.0) {
    throw std::invalid_argument(
        fmt::format("the pose is no rigid motion: R' R is {:.3g} from the identity (at most {:.3g}), det R = {:.3g}",
                    error, kTolerance, R.determinant()));
  }
}

}  // namespace

Scene::Scene(std::vector<Obstacle> obstacles) : obstacles_{std::move(obstacles)} {
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    for (std::size_t s = 0; s < obstacles_[i].shapes.size(); ++s) {
      const PlacedShape& placed = obstacles_[i].shapes[s];
      try {
        check(placed.shape);
        check_pose(placed.X_FG);
      } catch (const std::invalid_argument& error) {
        throw std::invalid_argument(
            fmt::format("Scene: obstacle {} ('{}'), shape {}: {}", i, obstacles_[i].name, s, error.what()));
      }
      placed_.push_back({static_cast<int>(i), static_cast<int>(s),
                         bounding_capsule(placed.shape, bounding_radius(placed.shape), placed.X_FG)});
    }
  }
}

const PlacedShape& Scene::shape_of(const Placed& placed) const {
  return obstacles_[static_cast<std::size_t>(placed.obstacle)].shapes[static_cast<std::size_t>(placed.shape)];
}

double Scene::clearance(const Arm& arm, const Posture& posture, Work& work) const {
  // The pair whose capsules are closest goes first: its distance spares most of the others the exact test.
  double least_gap = kInfinity;
  const ArmGeometry* favourite_geometry = nullptr;
  const Placed* favourite = nullptr;
  for (const ArmGeometry& geometry : arm.geometries()) {
    const BoundingCapsule capsule = capsule_of(geometry, pose_of(geometry, posture));
    for (const Placed& placed : placed_) {
      const double bound = gap(capsule, placed.capsule);
      if (bound >= least_gap) continue;
      least_gap = bound;
      favourite_geometry = &geometry;
      favourite = &placed;
    }
  }
  if (favourite == nullptr) return kInfinity;

  double least = kInfinity;
  const auto look = [&](const ArmGeometry& geometry, const Eigen::Isometry3d& X_WG, const Placed& placed) {
    const PlacedShape& obstacle = shape_of(placed);
    ++work.distances;
    least = std::min(least, signed_distance(geometry.shape, X_WG, obstacle.shape, obstacle.X_FG));
  };
  look(*favourite_geometry, pose_of(*favourite_geometry, posture), *favourite);
  for (const ArmGeometry& geometry : arm.geometries()) {
    const Eigen::Isometry3d X_WG = pose_of(geometry, posture);
    const BoundingCapsule capsule = capsule_of(geometry, X_WG);
    for (const Placed& placed : placed_) {
      if (&geometry == favourite_geometry && &placed == favourite) continue;
      if (gap(capsule, placed.capsule) < least) look(geometry, X_WG, placed);
    }
  }
  return least;
}

bool Scene::collides(const Arm& arm, const Posture& posture, Work& work) const {
  for (const ArmGeometry& geometry : arm.geometries()) {
    const Eigen::Isometry3d X_WG = pose_of(geometry, posture);
    const BoundingCapsule capsule = capsule_of(geometry, X_WG);
    for (const Placed& placed : placed_) {
      if (gap(capsule, placed.capsule) > 0.0) continue;
      const PlacedShape& obstacle = shape_of(placed);
      ++work.distances;
      if (overlaps(geometry.shape, X_WG, obstacle.shape, obstacle.X_FG)) return true;
    }
  }
  return false;
}

std::vector<Contact> Scene::contacts(const Arm& arm, const Posture& posture, double margin, Work& work) const {
  std::vector<Contact> result;
  for (std::size_t g = 0; g < arm.geometries().size(); ++g) {
    const ArmGeometry& geometry = arm.geometries()[g];
    const Eigen::Isometry3d X_WG = pose_of(geometry, posture);
    const BoundingCapsule capsule = capsule_of(geometry, X_WG);
    for (const Placed& placed : placed_) {
      if (gap(capsule, placed.capsule) >= margin) continue;
      const PlacedShape& obstacle = shape_of(placed);
      ++work.distances;
      const Separation found = separation(geometry.shape, X_WG, obstacle.shape, obstacle.X_FG);
      if (found.distance < margin) result.push_back({found, static_cast<int>(g), placed.obstacle, placed.shape});
    }
  }
  return result;
}

double Scene::clearance(const Eigen::Vector3d& p_W) const {
  const Shape point = Sphere{0.0};
  const Eigen::Isometry3d X_WP{Eigen::Translation3d{p_W}};
  const BoundingCapsule capsule{p_W, Eigen::Vector3d::Zero(), 0.0};
  double least = kInfinity;
  for (const Placed& placed : placed_) {
    if (gap(capsule, placed.capsule) >= least) continue;
    const PlacedShape& obstacle = shape_of(placed);
    least = std::min(least, signed_distance(point, X_WP, obstacle.shape, obstacle.X_FG));
  }
  return least;
}

double self_clearance(const Arm& arm, const Posture& posture, Work& work) {
  double least = kInfinity;
  detail::any_self_pair(arm, [&](std::size_t first, std::size_t second) {
    const ArmGeometry& a = arm.geometries()[first];
    const ArmGeometry& b = arm.geometries()[second];
    const Eigen::Isometry3d X_WA = pose_of(a, posture);
    const Eigen::Isometry3d X_WB = pose_of(b, posture);
    if (gap(capsule_of(a, X_WA), capsule_of(b, X_WB)) >= least) return false;
    ++work.distances;
    least = std::min(least, signed_distance(a.shape, X_WA, b.shape, X_WB));
    return false;
  });
  return least;
}

bool self_collides(const Arm& arm, const Posture& posture, Work& work) {
  return detail::any_self_pair(arm, [&](std::size_t first, std::size_t second) {
    const ArmGeometry& a = arm.geometries()[first];
    const ArmGeometry& b = arm.geometries()[second];
    const Eigen::Isometry3d X_WA = pose_of(a, posture);
    const Eigen::Isometry3d X_WB = pose_of(b, posture);
    if (gap(capsule_of(a, X_WA), capsule_of(b, X_WB)) > 0.0) return false;
    ++work.distances;
    return overlaps(a.shape, X_WA, b.shape, X_WB);
  });
}

std::vector<Contact> self_contacts(const Arm& arm, const Posture& posture, double margin, Work& work) {
  std::vector<Contact> result;
  detail::any_self_pair(arm, [&](std::size_t first, std::size_t second) {
    const ArmGeometry& a = arm.geometries()[first];
    const ArmGeometry& b = arm.geometries()[second];
    const Eigen::Isometry3d X_WA = pose_of(a, posture);
    const Eigen::Isometry3d X_WB = pose_of(b, posture);
    if (gap(capsule_of(a, X_WA), capsule_of(b, X_WB)) >= margin) return false;
    ++work.distances;
    const Separation found = separation(a.shape, X_WA, b.shape, X_WB);
    if (found.distance < margin) result.push_back({found, static_cast<int>(first), static_cast<int>(second), -1});
    return false;
  });
  return result;
}

}  // namespace modsearch
