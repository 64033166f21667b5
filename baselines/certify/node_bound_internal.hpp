#pragma once

#include <array>
#include <modsearch/baselines/certify/sequence_model_internal.hpp>

namespace modsearch::certify {

/// That a body point keeps clear of an obstacle: of a ball inside obstacle shape `shape`, or of its face `face` (0 ..
/// 5: +x, -x, +y, -y, +z, -z of its frame).
struct Row {
  int goal = 0;
  int run = 0;
  double tau = 0.0;  ///< place of the body point between the ends of the run's inner axis
  int shape = 0;
  bool ball = true;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.0;
  int face = 0;
  double multiplier = 0.0;  ///< of the row with a normal of unit length, >= 0
};

/// What shows that a box holds no design worth having.
struct Multipliers {
  std::vector<Eigen::Vector3d> y;  ///< per goal [kg/m]
  std::vector<Row> rows;
  bool cap = false;  ///< first-order form, for boxes with wide angles
};

/// How bounds are formed.
enum class Objective {
  kMass,    ///< no achieved design in the box weighs less
  kNothing  ///< positive only if none is achieved
};

/// The bound of CERTIFICATES' checker (docs/certificates.md) in doubles, with its gradient in the multipliers, for one
/// box after another. Nothing is allocated once the first boxes were seen.
class NodeBound {
 public:
  /// Both must outlive it.
  NodeBound(const SequenceModel& model, const Scenery& scenery);

  /// From here on about `box`, without rows.
  void set_box(const Box& box);
  /// Adds the row; false, and nothing was added, where it does not hold in the whole box.
  bool add_row(const Row& row);
  void clear_rows();

  /// Multipliers in a row: y goal by goal, then one of each row with its normal scaled to unit length.
  [[nodiscard]] int n_multipliers() const { return 3 * n_goals_ + n_rows_; }
  [[nodiscard]] int n_rows() const { return n_rows_; }
  [[nodiscard]] const Row& row(int r) const { return rows_[static_cast<std::size_t>(r)].row; }
  /// Length of the row's normal as the certificate has it.
  [[nodiscard]] double normal_length(int r) const { return rows_[static_cast<std::size_t>(r)].length; }

  /// The bound, concave in the multipliers; with its gradient [n_multipliers] if `gradient` is not null.
  double value(const double* multipliers, bool cap, Objective objective, double* gradient);

  /// Of the last value in second-order form: the bound with variable `v` held at its lower and upper end; between them
  /// it is concave.
  struct Ends {
    double lower = 0.0;
    double upper = 0.0;
  };
  [[nodiscard]] Ends ends(int v) const;
  /// Of the last value in second-order form: what the width of each variable costs [n_variables].
  void losses(const double* multipliers, std::vector<double>& result) const;

  /// d tip / d variable at the centre of the box [m per unit].
  [[nodiscard]] Eigen::Vector3d tip_derivative(int goal, int v) const;
  /// The tip there [m].
  [[nodiscard]] const Eigen::Vector3d& tip(int goal) const { return tips_[static_cast<std::size_t>(goal)]; }

  [[nodiscard]] const Box& box() const { return box_; }
  [[nodiscard]] const std::vector<double>& middle() const { return middle_; }

  /// Where a body point is at the centre of the box, and how far from there it can be in it [m].
  struct BodyPoint {
    Eigen::Vector3d x;
    double reach = 0.0;
  };
  [[nodiscard]] BodyPoint body_point(int goal, int run, double tau) const;
  /// What the variables add to that reach [n_variables].
  void reach_shares(int goal, int run, double tau, std::vector<double>& result) const;
  /// The run may be shorter than it is thick in the box: no row is about it.
  [[nodiscard]] bool too_short(int run) const;

 private:
  // R_j b(z) of one goal with its derivatives, sparse in the lengths.
  struct Block {
    int acting = 0;
    int n = 0;                               // parts: the offset and columns that are not zero
    std::vector<int> form;                   // of each part: 0 the offset, k + 1 length k
    std::vector<Eigen::Vector3d> w;          // [n], world axes
    std::vector<Eigen::Vector3d> first;      // [acting x n]: axis_v x w
    std::vector<Eigen::Vector3d> second;     // [pairs x n]: axis_v x (axis_w x w), v <= w
    std::vector<Eigen::Vector3d> at_corner;  // [corners]
    std::vector<double> length;              // [corners]
  };
  struct PlacedRow {
    Row row;
    double length = 0.0;  // of the normal
    Eigen::Vector3d n;    // unit
    double beta = 0.0;    // of the unit normal
    Block block;
  };
  // A goal's frame: the terms a . R_j b that it has.
  struct Group {
    int goal = 0;
    int frame = 0;
    int acting = 0;
    double delta = 0.0;
    int choice = 0;                              // at the worst corner
    std::vector<double> forms;                   // second derivatives [pairs x (n_lengths + 1)]
    std::vector<int> rows;                       // that are about points of the frame
    std::vector<std::array<double, 4>> choices;  // [corners]
  };

  [[nodiscard]] std::size_t joint(int g, int j) const { return static_cast<std::size_t>(g * n_joints_ + j); }
  [[nodiscard]] std::size_t frame(int g, int j) const { return static_cast<std::size_t>(g * (n_joints_ + 1) + j); }
  void fill(Block& block, int g, int frame, const AffineVector& b, int acting) const;
  void set_corners();
  void pulls(const double* multipliers);
  [[nodiscard]] double constant(const double* multipliers, double* gradient) const;
  double second_order(const double* multipliers, Objective objective, double* gradient);
  // Adds to that of the constant part, at the last value.
  void second_order_gradient(const double* multipliers, double* gradient) const;
  double cap_order(const double* multipliers, Objective objective, double* gradient);
  void scatter(const Group& group, int term, const Eigen::Vector3d& g, double* gradient) const;
  [[nodiscard]] const Block& block_of(const Group& group, int term) const;
  [[nodiscard]] Eigen::Vector3d weight_of(const Group& group, int term, const double* multipliers) const;
  [[nodiscard]] double curvature(const Group& group, std::size_t corner, double* share) const;
  // A form that is linear in the lengths, at a corner.
  [[nodiscard]] double form_at(const double* form, std::size_t corner) const {
    const auto stride = static_cast<std::size_t>(n_lengths_ + 1);
    const double* z = &corners_[corner * stride];
    double value = 0.0;
    for (std::size_t i = 0; i < stride; ++i) value += form[i] * z[i];
    return value;
  }

  const SequenceModel& model_;
  const Scenery& scenery_;
  int n_goals_ = 0;
  int n_lengths_ = 0;
  int n_joints_ = 0;
  std::size_t n_corners_ = 0;
  Box box_;
  std::vector<double> middle_;           // of all variables
  std::vector<double> half_;             // half-widths of all variables
  std::vector<double> delta_;            // [goals x (n_joints + 1)]
  std::vector<Eigen::Matrix3d> turn_;    // R_j [goals x (n_joints + 1)]
  std::vector<Eigen::Vector3d> axis_;    // [goals x n_joints]
  std::vector<Eigen::Vector3d> tips_;    // [goals]
  std::vector<Eigen::Vector3d> origin_;  // of each frame at the centre [goals x (n_joints + 1)]
  std::vector<double> swing_;            // how far it can be from there [goals x (n_joints + 1)]
  std::vector<double> stretch_;          // of that, per length: the lengths of the columns before the frame
  std::vector<double> corners_;          // [corners x (n_lengths + 1)], the first entry 1
  std::vector<Block> blocks_;            // [goals x (n_joints + 1)]
  std::vector<Group> groups_;
  std::vector<PlacedRow> rows_;
  int n_rows_ = 0;

  // Of the last value.
  std::vector<Eigen::Vector3d> pull_;  // [goals x (n_joints + 1)]
  std::vector<double> rest_;           // [n_lengths + 1]
  std::vector<double> slopes_;         // [goals x n_joints x (n_lengths + 1)]
  std::vector<double> slope_at_;       // [corners x goals x n_joints]
  std::vector<double> corner_value_;   // [corners]
  std::size_t worst_ = 0;
  double constant_ = 0.0;
};

}  // namespace modsearch::certify
