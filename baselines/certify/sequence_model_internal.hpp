#pragma once

#include <modsearch/problem/robot_problem.hpp>
#include <optional>
#include <string>
#include <vector>

namespace modsearch::certify {

/// How far parameters may be outside their intervals, tips outside their goals, joints beyond their limits and bodies
/// inside obstacles in what is proved: the checker allows as much [m], [rad].
inline constexpr double kSlack = 1e-12;

/// A goal that is a ball about a position.
struct Target {
  Eigen::Vector3d position;
  double radius = 0.0;
};

/// What is proved something about: the goals and the obstacles.
struct Scenery {
  std::vector<Target> targets;
  std::vector<PlacedShape> obstacles;  ///< all shapes, in the world; none where the level ignores them
};

/// Why nothing can be proved about the problem beyond the reach of its modules; nothing: something can.
[[nodiscard]] std::optional<std::string> why_not_covered(const RobotProblem& problem);
[[nodiscard]] Scenery scenery_of(const RobotProblem& problem);

/// What lies between two joints, in the frame that turns with the joint before: frame 0 stands on the world, frame
/// j + 1 is turned by R -> R * turn * Rz(q_j). The tip is at the sum over frames of R_j v_j.
struct ModelFrame {
  AffineVector v;  ///< affine in the lengths [m]
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  int acting = 0;  ///< so many joints, counted from the base, turn v at all
};

/// A straight cylinder that is fixed to a frame, or several that continue one another: rows are about points of its
/// axis, `radius` off its flat ends.
struct StraightRun {
  int frame = 0;
  int acting = 0;  ///< joints that turn its points about the origin of its frame
  Eigen::Vector3d axis;
  AffineVector start;  ///< affine in the lengths, in the coordinates of the frame [m]
  AffineVector end;
  double radius = 0.0;
  bool usable = false;
};

/// The arms that a sequence of module types can become, as the certificate's checker sees them: collinear parameters
/// that weigh alike are one length. Variables are the lengths, then the joints goal by goal.
struct SequenceModel {
  std::vector<int> types;
  std::vector<int> length_of;       ///< [n_parameters]
  Eigen::VectorXd parameter_lower;  ///< [n_parameters]
  Eigen::VectorXd parameter_upper;
  std::vector<double> lower;  ///< of the lengths [m], widened by the slack
  std::vector<double> upper;
  std::vector<ModelFrame> frames;   ///< [n_joints + 1]
  std::vector<double> joint_lower;  ///< [rad]
  std::vector<double> joint_upper;
  std::vector<bool> idle;  ///< may stand still, because the next, about a parallel axis, turns for it
  std::vector<StraightRun> runs;
  double mass = 0.0;           ///< with all lengths 0 [kg]
  std::vector<double> masses;  ///< [kg/m]

  /// Throws std::invalid_argument if `types` do not fit together.
  SequenceModel(const RobotProblem& problem, std::span<const int> types);

  [[nodiscard]] int n_lengths() const { return static_cast<int>(lower.size()); }
  [[nodiscard]] int n_joints() const { return static_cast<int>(joint_lower.size()); }
  [[nodiscard]] int acting(int frame, const AffineVector& vector) const;
  /// Small enough for the search and for the checker.
  [[nodiscard]] bool fits() const { return n_lengths() <= 10 && n_joints() <= 12; }
  /// Parameters whose sums are `lengths`, stretched alike, within their intervals.
  [[nodiscard]] Eigen::VectorXd parameters(const std::vector<double>& lengths) const;
};

/// An interval per variable of a model.
struct Box {
  std::vector<double> lower;
  std::vector<double> upper;

  [[nodiscard]] int size() const { return static_cast<int>(lower.size()); }
  [[nodiscard]] double width(int v) const {
    return upper[static_cast<std::size_t>(v)] - lower[static_cast<std::size_t>(v)];
  }
};
[[nodiscard]] Box root_box(const SequenceModel& model, int n_goals);

/// Least and greatest mass of the arms with lengths in the box [kg].
[[nodiscard]] double least_mass(const SequenceModel& model, const Box& box);
[[nodiscard]] double greatest_mass(const SequenceModel& model, const Box& box);

}  // namespace modsearch::certify
