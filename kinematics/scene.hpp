#pragma once

#include <limits>
#include <modsearch/kinematics/arm.hpp>
#include <modsearch/kinematics/bounding_capsule.hpp>
#include <modsearch/kinematics/separation.hpp>
#include <modsearch/kinematics/work.hpp>
#include <string>
#include <vector>

namespace modsearch {

/// How something moves: poses at times, in between the position on a straight line and the rotation about one axis,
/// both at constant speed; before the first and after the last it rests.
struct Keyframes {
  std::vector<double> times;              ///< [s], rising
  std::vector<Eigen::Isometry3d> X_WO{};  ///< at these times

  [[nodiscard]] Eigen::Isometry3d at(double t) const;
  /// No point within `reach` [m] of the origin of O moves faster than this between times `from` and `to` [m/s].
  [[nodiscard]] double fastest(double reach, double from, double to) const;
};

/// Something the arm must not touch: fixed in the world, or moving as a whole.
struct Obstacle {
  std::string name;
  std::vector<PlacedShape> shapes;  ///< X_FG is X_OG; O is the world where the obstacle is fixed
  Keyframes motion{};               ///< no keyframes: fixed

  [[nodiscard]] bool moves() const { return !motion.times.empty(); }
};

/// Where an arm and a scene (or an arm and itself) come closest.
struct Contact {
  Separation separation;  ///< A is the arm's shape `geometry`, B the obstacle's or the arm's other shape
  int geometry = -1;      ///< index into Arm::geometries(); -1: nothing to compare
  int other = -1;         ///< obstacle index, or the other geometry for self-collision
  int other_shape = -1;   ///< shape of the obstacle
};

/// The obstacles around an arm. Immutable; safe to share between threads.
///
/// Whatever does not take a time looks at the obstacles that do not move; `space_time.hpp` looks at the others.
///
/// Every pair of shapes is first compared by capsules around them; only pairs these cannot part reach the exact test,
/// so the answers are those of the exact test alone. Pairs go in a fixed order: arm geometries, obstacles, their
/// shapes.
class Scene {
 public:
  Scene() = default;
  /// Throws std::invalid_argument, naming the obstacle, for a shape that `check` refuses, for a pose that is not finite
  /// or whose rotation is none, and for keyframes whose times do not rise or are not as many as their poses.
  explicit Scene(std::vector<Obstacle> obstacles);

  [[nodiscard]] const std::vector<Obstacle>& obstacles() const { return obstacles_; }
  [[nodiscard]] bool any_moves() const { return any_moves_; }
  [[nodiscard]] bool any_rests() const { return !placed_.empty(); }

  /// Least signed distance between any body of the arm at `posture` and any obstacle [m]; negative: overlap; +inf:
  /// nothing to compare. `work.distances` counts the pairs that the capsules could not part.
  /// Never more than `ceiling`: what is known to be farther away is not measured, which makes the least clearance of
  /// many postures cheap to find. Where it is at most `floor`, any number between it and `floor` may be the answer: the
  /// posture with the largest clearance of many is cheap to find as well.
  [[nodiscard]] double clearance(const Arm& arm, const Posture& posture, Work& work,
                                 double ceiling = std::numeric_limits<double>::infinity(),
                                 double floor = -std::numeric_limits<double>::infinity()) const;
  /// Whether any body overlaps any obstacle; stops at the first. Much cheaper than the distance.
  [[nodiscard]] bool collides(const Arm& arm, const Posture& posture, Work& work) const;
  /// The separation of every (arm geometry, obstacle shape) pair closer than `margin` [m], in a fixed order.
  [[nodiscard]] std::vector<Contact> contacts(const Arm& arm, const Posture& posture, double margin, Work& work) const;

  /// Least signed distance between a point and the obstacles [m]; +inf without obstacles.
  [[nodiscard]] double clearance(const Eigen::Vector3d& p_W) const;

 private:
  friend class EdgeChecker;
  struct Placed {
    int obstacle;
    int shape;
    BoundingCapsule capsule;
  };
  [[nodiscard]] const PlacedShape& shape_of(const Placed& placed) const;

  std::vector<Obstacle> obstacles_;
  std::vector<Placed> placed_;  // every shape of every obstacle that does not move, in order
  bool any_moves_ = false;
};

/// Least signed distance between two bodies of the arm that are not neighbours (Chain::self_pairs) [m]; +inf: no pairs.
/// `ceiling` and `floor`: as in Scene::clearance.
[[nodiscard]] double self_clearance(const Arm& arm, const Posture& posture, Work& work,
                                    double ceiling = std::numeric_limits<double>::infinity(),
                                    double floor = -std::numeric_limits<double>::infinity());
/// Whether two bodies that are not neighbours overlap; stops at the first pair.
[[nodiscard]] bool self_collides(const Arm& arm, const Posture& posture, Work& work);
/// The separation of every pair of geometries of non-neighbouring bodies closer than `margin` [m], in a fixed order.
[[nodiscard]] std::vector<Contact> self_contacts(const Arm& arm, const Posture& posture, double margin, Work& work);

}  // namespace modsearch
