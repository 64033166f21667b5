#pragma once

#include <modsearch/kinematics/parametric_pose.hpp>
#include <string>
#include <utility>
#include <vector>

namespace modsearch {

class Arm;

enum class JointType { kRevolute, kPrismatic, kContinuous };

/// One axis of motion, about or along z of its frame.
struct Joint {
  std::string name;
  JointType type = JointType::kRevolute;
  double lower = 0.0;  ///< position limits [rad] or [m]; -inf, +inf for a continuous joint
  double upper = 0.0;
  double velocity = std::numeric_limits<double>::infinity();      ///< [rad/s] or [m/s]
  double acceleration = std::numeric_limits<double>::infinity();  ///< [rad/s^2] or [m/s^2]
  double peak_torque = std::numeric_limits<double>::infinity();   ///< [N m] or [N]

  /// Turns (does not slide).
  [[nodiscard]] bool rotates() const { return type != JointType::kPrismatic; }
  /// Every angle is within the limits, up to whole turns.
  [[nodiscard]] bool full_circle() const;
};

/// One collision shape of a body, placed in the frame the body moves with.
struct BodyGeometry {
  AffineShape shape;
  ParametricPose X_FG;
};

/// How the mass of a body is spread, in the body's own frame B.
struct MassSpread {
  ParametricPose X_FB;                                ///< B in the frame the body moves with
  AffineVector r_com;                                 ///< centre of mass in B [m]
  bool evenly = true;                                 ///< over the collision shapes: `inertia` is not looked at
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre of mass, axes of B [kg m^2]
};

/// A rigid piece of the arm.
struct Body {
  std::string name;
  int module = -1;  ///< placement it belongs to: -1 the base module, 0.. the modules of the design
  int frame = 0;    ///< frame it moves with: 0 fixed to the world, j + 1 moves with joint j
  AffineScalar mass;  ///< [kg]
  std::vector<BodyGeometry> geometries;
  MassSpread spread;  ///< see `inertial` (inertial.hpp)
};

/// Which pairs of bodies are never compared for self-collision ("neighbours", Timor's `ignore_collisions`).
enum class NeighbourRule {
  kRigid,          ///< bodies without a joint between them
  kViaJoint,       ///< these, and the two bodies that a joint connects
  kRigidViaJoint,  ///< these, and all bodies of two rigid groups one joint apart
};

/// A serial chain of one type sequence: lengths affine in the parameters x [n_parameters] (m; angles of twists: rad),
/// joints q [n_joints] (rad or m). Built once, evaluated at any (x, q) through `at(x)` without rebuilding.
///
/// Frames: frame 0 is the world W; frame j + 1 moves with joint j, its z axis is the joint's axis and its origin lies on
/// it; the tip E (TCP) is fixed in frame n_joints.
class Chain {
 public:
  [[nodiscard]] int n_parameters() const { return n_parameters_; }
  [[nodiscard]] int n_joints() const { return static_cast<int>(joints_.size()); }
  [[nodiscard]] const std::vector<Joint>& joints() const { return joints_; }
  [[nodiscard]] const std::vector<Body>& bodies() const { return bodies_; }
  /// Pairs of bodies (first < second) that self-collision compares: all but the neighbours.
  [[nodiscard]] const std::vector<std::pair<int, int>>& self_pairs() const { return self_pairs_; }

  /// Transform, fixed for given parameters, from frame j to the frame of joint j before it moves; `segment(n_joints())` leads to the tip.
  [[nodiscard]] const ParametricPose& segment(int j) const { return segments_[static_cast<std::size_t>(j)]; }

  /// Joint limits [n_joints]; infinite for continuous joints.
  [[nodiscard]] Eigen::VectorXd lower_limits() const;
  [[nodiscard]] Eigen::VectorXd upper_limits() const;
  /// `q` moved into the limits, component by component: turns are taken off full-circle joints, the others are clamped.
  [[nodiscard]] Eigen::VectorXd clamped(const Eigen::VectorXd& q) const;

  /// Total mass at `x` [kg], and the number affine in x itself.
  [[nodiscard]] double mass(const Eigen::VectorXd& x) const { return mass_.at(x); }
  [[nodiscard]] const AffineScalar& mass() const { return mass_; }

  /// The arm with lengths `x`. The chain must outlive it.
  /// Throws std::invalid_argument if x.size() != n_parameters() or a length of a shape becomes negative or not finite.
  [[nodiscard]] Arm at(const Eigen::VectorXd& x) const;

 private:
  friend class ChainBuilder;
  int n_parameters_ = 0;
  std::vector<Joint> joints_;
  std::vector<ParametricPose> segments_;  // [n_joints + 1]
  std::vector<Body> bodies_;
  std::vector<std::pair<int, int>> self_pairs_;
  AffineScalar mass_;
};

/// Builds a chain from the base outwards, keeping one current frame.
class ChainBuilder {
 public:
  explicit ChainBuilder(int n_parameters);

  /// Moves the current frame by a fixed transform (a fixed joint is nothing else), which parameters may shift and turn.
  ChainBuilder& move(const ParametricPose& X);
  /// Adds a joint about or along z of the current frame, which moves with it from here on.
  /// `parent`, `child`: the bodies it connects (indices given by `body`), for the neighbour rule; -1: none.
  /// Throws std::invalid_argument for limits that are reversed or NaN.
  ChainBuilder& joint(Joint joint, int parent = -1, int child = -1);
  /// Adds a body that moves with the current frame; its geometries, and X_FB of `spread`, are given in the current frame.
  /// Returns its index.
  int body(std::string name, int module, AffineScalar mass, std::vector<BodyGeometry> geometries,
           MassSpread spread = {});
  /// Ends the chain: the current frame is the tip.
  [[nodiscard]] Chain build(NeighbourRule rule = NeighbourRule::kViaJoint) const;

 private:
  Chain chain_;
  ParametricPose X_FC_;  // the current frame C in the frame F of the last joint
  std::vector<std::pair<int, int>> joined_;  // bodies that a joint connects
};

}  // namespace modsearch
