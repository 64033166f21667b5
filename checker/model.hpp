#pragma once

#include <checker/problem.hpp>

namespace modsearch_check {

/// What lies between two joints, in the frame that turns with the joint before: frame 0 stands on the world, frame j +
/// 1 is frame j turned by R -> R * turn * Rz(q_j). The tip is at the sum over frames of R_j v_j.
struct Frame {
  AffineVector v;          // to the origin of the next frame, or to the tip [m]
  Matrix turn;             // constant; unused in the last frame
  std::size_t acting = 0;  // so many joints, counted from the base, turn v at all
};

/// A straight cylinder of constant radius that is fixed to a frame, or several that continue one another.
struct Run {
  std::size_t frame = 0;
  Vector axis{};       // unit
  AffineVector start;  // centres of its two ends
  AffineVector end;
  double radius = 0.0;
  bool usable = false;
  double slack = 0.0;  // of cylinders that continue one another up to rounding: rows count on so much less radius [m]
};

struct PlacedBodyShape {
  std::size_t frame = 0;
  Shape shape;  // affine in all parameters of the design
};

/// The arms that a sequence of module types can become.
struct Model {
  std::vector<std::size_t> types;
  std::vector<Parameter> parameters;     // of all modules, base to tip
  std::vector<std::size_t> variable_of;  // the length that each parameter is part of
  std::vector<double> lower;             // [n_lengths], widened by the slack
  std::vector<double> upper;
  std::vector<Frame> frames;  // [n_joints + 1], affine in the lengths
  std::vector<Joint> joints;  // limits as in the file
  std::vector<bool> idle;     // joints that may stand still, because the next one, about a parallel axis, does as well
  std::vector<Run> runs;      // affine in the lengths
  std::vector<PlacedBodyShape> shapes;
  AffineScalar mass;  // affine in the lengths
  Interval costs;

  [[nodiscard]] std::size_t n_lengths() const { return lower.size(); }
  [[nodiscard]] std::size_t n_joints() const { return joints.size(); }
  /// Joints, counted from the base, that turn a vector of frame `j`.
  [[nodiscard]] std::size_t acting(std::size_t j, const AffineVector& vector) const;
};

/// Follows connectors from module to module.
class Assembler {
 public:
  explicit Assembler(const Problem& problem) : problem_{&problem} {}

  /// Whether each of `types` fits the one before, the first the base.
  [[nodiscard]] bool fits(const std::vector<std::size_t>& types) const;
  /// Throws Malformed for a library whose joints do not make chains, Rejected for arms that are too large.
  [[nodiscard]] Model model(const std::vector<std::size_t>& types) const;

 private:
  const Problem* problem_;
};

}  // namespace modsearch_check
