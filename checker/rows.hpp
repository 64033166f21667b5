#pragma once

#include <checker/bound.hpp>
#include <checker/posture.hpp>

namespace modsearch_check {

/// A row as an inequality that every achieved design in the box satisfies: normal . x >= beta, x = `point` of frame
/// `frame` carried into the world at one goal.
struct Inequality {
  std::size_t frame = 0;
  AffineVector point;
  Vector normal{};
  double beta = 0.0;
};

/// The box of angles of one goal, seen from its centre.
struct Angles {
  std::vector<double> middle;  // [n_joints]
  std::vector<double> half;    // half-widths, the box is covered [n_joints]
  std::vector<double> delta;   // delta[k]: sum of the first k half-widths [n_joints + 1]
  Posture centre;

  Angles(const Model& model, const Box& box, std::size_t goal);
};

/// Works a row out. Throws Rejected where it does not hold in the whole box.
[[nodiscard]] Inequality inequality(const Problem& problem, const Model& model, const Box& box, const Angles& angles,
                                    const Row& row);

}  // namespace modsearch_check
