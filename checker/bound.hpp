#pragma once

#include <checker/model.hpp>

namespace modsearch_check {

/// An interval per variable: the lengths, then the joints of the first goal (base first), of the second, ..
struct Box {
  std::vector<double> lower;
  std::vector<double> upper;
};

/// What a body keeps clear of: a ball inside obstacle `shape`, or the face `face` of the box `shape`
/// (0 .. 5: +x, -x, +y, -y, +z, -z of its frame).
struct Row {
  std::size_t goal = 0;
  std::size_t run = 0;
  double tau = 0.0;  // place of the body point between the ends of the run's inner axis
  double mu = 0.0;
  std::size_t shape = 0;
  bool ball = true;
  Numbers centre{};
  double radius = 0.0;
  std::size_t face = 0;
};

/// The multipliers that show what a leaf of a tree claims.
struct Leaf {
  bool mass = true;        // a bound of the mass; else that nothing in the box is achieved
  bool cap = false;        // first-order form
  std::vector<Numbers> y;  // per goal
  std::vector<Row> rows;
};

/// The box that holds every posture of every arm of the model.
[[nodiscard]] Box root_box(const Model& model, std::size_t n_goals);

/// The bound at the corners of the box of lengths; corner c has length i at its upper end where bit i of c is set.
struct Corners {
  std::vector<Interval> values;               // [corners]
  std::vector<std::vector<Interval>> slopes;  // dF/dq there, unless in first-order form [corners x angles]
};

/// What the multipliers of a leaf show about a box. Of a mass leaf: no achieved design weighs less. Of the others:
/// positive only if none is achieved.
///
/// An achieved design has y_g . p_g >= y_g . t_g - radius_g |y_g| for any y_g, p_g being the tip at goal g, and n . x
/// >= beta for a body point x that an obstacle keeps away. So with y_g and mu >= 0 as multipliers
///     mass >= sum_g (y_g . t_g - radius_g |y_g|) + sum mu beta + min over the box of [mass(z) - F(z, q)],
///     F = sum_g y_g . p_g + sum mu n . x.
/// F is a sum of terms a . R_j(q) b(z), b affine in the lengths z. From the centre c of the angles, Taylor's series
/// bounds F above by F(z, c) + sum_v h_v |dF/dq_v| + remainders; each summand is convex in z, so what is in brackets is
/// bounded below by a concave function, which is least at a corner of the box of lengths.
///
/// About the part of the box beyond a place of one variable, all else as before, the same expansion shows more: its
/// slope counts from the place on instead of over the whole width, and concave in a length is above its chord.
class Shown {
 public:
  /// Throws Rejected for a row that does not hold.
  Shown(const Problem& problem, const Model& model, const Box& box, const Leaf& leaf);
  /// About all of the box.
  [[nodiscard]] double in_box() const;
  /// About the part of it in which `variable` is at least (`above`) or at most `at`, a place in its interval. Throws
  /// Rejected for an angle in first-order form.
  [[nodiscard]] double in_part(std::size_t variable, double at, bool above) const;

 private:
  Box box_;
  std::size_t n_lengths_ = 0;
  bool cap_ = false;
  std::vector<double> middle_;  // of the angles of all goals
  std::vector<double> half_;    // their half-widths
  Corners corners_;
};

[[nodiscard]] double lower_bound(const Problem& problem, const Model& model, const Box& box, const Leaf& leaf);

}  // namespace modsearch_check
