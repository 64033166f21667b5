#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/kinematics/interruption.hpp>
#include <modsearch/kinematics/scene.hpp>
#include <modsearch/kinematics/self_pairs_internal.hpp>
#include <stdexcept>

#include "fcl_backend_internal.hpp"

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Isometry3d pose_of(const ArmGeometry& geometry, const Posture& posture) {
  return posture.frames[static_cast<std::size_t>(geometry.frame)] * geometry.X_FG;
}

BoundingCapsule capsule_of(const ArmGeometry& geometry, const Posture& posture) {
  const Eigen::Isometry3d& X_WF = posture.frames[static_cast<std::size_t>(geometry.frame)];
  BoundingCapsule capsule = bounding_capsule(geometry.shape, geometry.bounding_radius, geometry.X_FG);
  capsule.centre_W = X_WF.linear() * capsule.centre_W + X_WF.translation();
  capsule.half_axis_W = X_WF.linear() * capsule.half_axis_W;
  return capsule;
}

// The capsules of all geometries of an arm, on the stack for all but very long arms.
class ArmCapsules {
 public:
  ArmCapsules(const Arm& arm, const Posture& posture) {
    const std::vector<ArmGeometry>& geometries = arm.geometries();
    if (geometries.size() > few_.size()) many_.resize(geometries.size());
    capsules_ = many_.empty() ? few_.data() : many_.data();
    for (std::size_t g = 0; g < geometries.size(); ++g) capsules_[g] = capsule_of(geometries[g], posture);
  }
  ArmCapsules(const ArmCapsules&) = delete;
  ArmCapsules& operator=(const ArmCapsules&) = delete;

  [[nodiscard]] const BoundingCapsule& operator[](std::size_t g) const { return capsules_[g]; }

 private:
  std::array<BoundingCapsule, 24> few_;
  std::vector<BoundingCapsule> many_;
  BoundingCapsule* capsules_;
};

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

void check_motion(const Keyframes& motion) {
  if (motion.times.size() != motion.X_WO.size()) {
    throw std::invalid_argument(fmt::format("{} times for {} poses", motion.times.size(), motion.X_WO.size()));
  }
  for (std::size_t i = 0; i < motion.times.size(); ++i) {
    if (!std::isfinite(motion.times[i]) || (i > 0 && motion.times[i] <= motion.times[i - 1])) {
      throw std::invalid_argument(
          fmt::format("time {} is {} s, must be finite and later than the one before it", i, motion.times[i]));
    }
    check_pose(motion.X_WO[i]);
  }
}

// Keyframe i and i + 1 are those around time t, which lies between the first and the last.
std::size_t keyframe_before(const Keyframes& motion, double t) {
  const auto after = std::upper_bound(motion.times.begin(), motion.times.end() - 1, t);
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, after - motion.times.begin() - 1));
}

}  // namespace

Eigen::Isometry3d Keyframes::at(double t) const {
  if (times.empty()) return Eigen::Isometry3d::Identity();
  if (t <= times.front()) return X_WO.front();
  if (t >= times.back()) return X_WO.back();
  const std::size_t i = keyframe_before(*this, t);
  const double part = (t - times[i]) / (times[i + 1] - times[i]);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Quaterniond{X_WO[i].linear()}
                   .slerp(part, Eigen::Quaterniond{X_WO[i + 1].linear()})
                   .normalized()
                   .toRotationMatrix();
  X.translation() = X_WO[i].translation() + part * (X_WO[i + 1].translation() - X_WO[i].translation());
  return X;
}

double Keyframes::fastest(double reach, double from, double to) const {
  double result = 0.0;
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    if (times[i + 1] <= from || times[i] >= to) continue;
    const double angle = Eigen::Quaterniond{X_WO[i].linear()}.angularDistance(Eigen::Quaterniond{X_WO[i + 1].linear()});
    const double way = (X_WO[i + 1].translation() - X_WO[i].translation()).norm() + angle * reach;
    result = std::max(result, way / (times[i + 1] - times[i]));
  }
  return result;
}

Scene::Scene(std::vector<Obstacle> obstacles) : obstacles_{std::move(obstacles)} {
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    for (std::size_t s = 0; s < obstacles_[i].shapes.size(); ++s) {
      const PlacedShape& placed = obstacles_[i].shapes[s];
      try {
        check(placed.shape);
        check_pose(placed.X_FG);
        detail::prepare(placed.shape);
      } catch (const std::invalid_argument& error) {
        throw std::invalid_argument(
            fmt::format("Scene: obstacle {} ('{}'), shape {}: {}", i, obstacles_[i].name, s, error.what()));
      }
      if (obstacles_[i].moves()) continue;
      placed_.push_back({static_cast<int>(i), static_cast<int>(s),
                         bounding_capsule(placed.shape, bounding_radius(placed.shape), placed.X_FG)});
    }
    try {
      check_motion(obstacles_[i].motion);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(
          fmt::format("Scene: obstacle {} ('{}'), motion: {}", i, obstacles_[i].name, error.what()));
    }
    any_moves_ = any_moves_ || obstacles_[i].moves();
  }
}

const PlacedShape& Scene::shape_of(const Placed& placed) const {
  return obstacles_[static_cast<std::size_t>(placed.obstacle)].shapes[static_cast<std::size_t>(placed.shape)];
}

double Scene::clearance(const Arm& arm, const Posture& posture, Work& work, double ceiling, double floor) const {
  interruption_point();
  // The pair whose capsules are closest goes first: its distance spares most of the others the exact test.
  double least_gap = ceiling;
  const ArmGeometry* favourite_geometry = nullptr;
  const Placed* favourite = nullptr;
  for (const ArmGeometry& geometry : arm.geometries()) {
    const BoundingCapsule capsule = capsule_of(geometry, posture);
    for (const Placed& placed : placed_) {
      if (apart(capsule, placed.capsule, least_gap)) continue;
      least_gap = gap(capsule, placed.capsule);
      favourite_geometry = &geometry;
      favourite = &placed;
    }
  }
  if (favourite == nullptr) return ceiling;

  double least = ceiling;
  const auto look = [&](const ArmGeometry& geometry, const Placed& placed) {
    const PlacedShape& obstacle = shape_of(placed);
    ++work.distances;
    least = detail::distance_within(geometry.shape, pose_of(geometry, posture), obstacle.shape, obstacle.X_FG, least,
                                    floor);
  };
  look(*favourite_geometry, *favourite);
  for (const ArmGeometry& geometry : arm.geometries()) {
    const BoundingCapsule capsule = capsule_of(geometry, posture);
    for (const Placed& placed : placed_) {
      if (least <= floor) return least;
      if (&geometry == favourite_geometry && &placed == favourite) continue;
      if (!apart(capsule, placed.capsule, least)) look(geometry, placed);
    }
  }
  return least;
}

bool Scene::collides(const Arm& arm, const Posture& posture, Work& work) const {
  interruption_point();
  for (const ArmGeometry& geometry : arm.geometries()) {
    const BoundingCapsule capsule = capsule_of(geometry, posture);
    for (const Placed& placed : placed_) {
      if (apart(capsule, placed.capsule, 0.0)) continue;
      const PlacedShape& obstacle = shape_of(placed);
      ++work.distances;
      if (overlaps(geometry.shape, pose_of(geometry, posture), obstacle.shape, obstacle.X_FG)) return true;
    }
  }
  return false;
}

std::vector<Contact> Scene::contacts(const Arm& arm, const Posture& posture, double margin, Work& work) const {
  interruption_point();
  std::vector<Contact> result;
  for (std::size_t g = 0; g < arm.geometries().size(); ++g) {
    const ArmGeometry& geometry = arm.geometries()[g];
    const BoundingCapsule capsule = capsule_of(geometry, posture);
    for (const Placed& placed : placed_) {
      if (apart(capsule, placed.capsule, margin)) continue;
      const PlacedShape& obstacle = shape_of(placed);
      ++work.distances;
      const Separation found = separation(geometry.shape, pose_of(geometry, posture), obstacle.shape, obstacle.X_FG);
      if (found.distance < margin) result.push_back({found, static_cast<int>(g), placed.obstacle, placed.shape});
    }
  }
  return result;
}

double Scene::clearance(const Eigen::Vector3d& p_W) const {
  const Shape point = Sphere{0.0};
  const Eigen::Isometry3d X_WP{Eigen::Translation3d{p_W}};
  const BoundingCapsule capsule{.centre_W = p_W};
  double least = kInfinity;
  for (const Placed& placed : placed_) {
    if (apart(capsule, placed.capsule, least)) continue;
    const PlacedShape& obstacle = shape_of(placed);
    least = std::min(least, signed_distance(point, X_WP, obstacle.shape, obstacle.X_FG));
  }
  return least;
}

double self_clearance(const Arm& arm, const Posture& posture, Work& work, double ceiling, double floor) {
  const ArmCapsules capsules(arm, posture);
  double least = ceiling;
  detail::any_self_pair(arm, [&](std::size_t first, std::size_t second) {
    if (apart(capsules[first], capsules[second], least)) return false;
    const ArmGeometry& a = arm.geometries()[first];
    const ArmGeometry& b = arm.geometries()[second];
    ++work.distances;
    least = detail::distance_within(a.shape, pose_of(a, posture), b.shape, pose_of(b, posture), least, floor);
    return least <= floor;
  });
  return least;
}

bool self_collides(const Arm& arm, const Posture& posture, Work& work) {
  const ArmCapsules capsules(arm, posture);
  return detail::any_self_pair(arm, [&](std::size_t first, std::size_t second) {
    if (apart(capsules[first], capsules[second], 0.0)) return false;
    const ArmGeometry& a = arm.geometries()[first];
    const ArmGeometry& b = arm.geometries()[second];
    ++work.distances;
    return overlaps(a.shape, pose_of(a, posture), b.shape, pose_of(b, posture));
  });
}

std::vector<Contact> self_contacts(const Arm& arm, const Posture& posture, double margin, Work& work) {
  const ArmCapsules capsules(arm, posture);
  std::vector<Contact> result;
  detail::any_self_pair(arm, [&](std::size_t first, std::size_t second) {
    if (apart(capsules[first], capsules[second], margin)) return false;
    const ArmGeometry& a = arm.geometries()[first];
    const ArmGeometry& b = arm.geometries()[second];
    ++work.distances;
    const Separation found = separation(a.shape, pose_of(a, posture), b.shape, pose_of(b, posture));
    if (found.distance < margin) result.push_back({found, static_cast<int>(first), static_cast<int>(second), -1});
    return false;
  });
  return result;
}

}  // namespace modsearch
