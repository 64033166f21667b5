#pragma once

#include <modsearch/kinematics/scene.hpp>
#include <modsearch/problem/pose_rows_internal.hpp>

namespace modsearch::detail {

/// The clearances of an arm at the goals of a task as rows of a smooth program: one for every goal and pair of shapes
/// (of a body and an obstacle that does not move, or of two bodies that are not neighbours). Only a working set of them
/// are rows, in the order in which they were added.
///
/// All pairs are looked at in bulk: balls about the shapes, kept as arrays of numbers, part nearly all of them,
/// capsules most others. Of what is left the distance is measured once; from then on the direction in which the shapes
/// were apart mostly shows that they still are (a separating axis, as in van den Bergen, A fast and robust GJK
/// implementation, 1999).
class ClearanceRows {
 public:
  /// `chain` and `scene` must outlive it. `obstacles`, `self`: which pairs count. `longest`: an arm of the chain no
  /// shape of which is larger at any other parameters.
  ClearanceRows(const Chain& chain, const Scene& scene, bool obstacles, bool self, const Arm& longest);

  /// All pairs at all goals that there are.
  [[nodiscard]] std::size_t n_pairs() const { return pairs_.size(); }
  [[nodiscard]] std::size_t n_rows() const { return rows_.size(); }

  /// Takes other parameters: those of `arm`.
  void set_parameters(const Arm& arm);
  /// Adds every pair at `goal` that is not a row yet and closer than `distance` [m], or with an infinite distance all.
  void add(const Arm& arm, const Posture& posture, int goal, double distance);
  /// Takes all rows away.
  void clear();

  /// Distances and gradients of the rows of `goal`; row 0 is number `first_row` of the program. Entries of the Jacobian
  /// are 0 before. `moves`: those of the arm at `posture`, `order` says which of them move a frame.
  void evaluate(const Arm& arm, const Posture& posture, const ArmMoves& order, std::span<const Move> moves, int goal,
                GoalColumns columns, Eigen::Index first_row, SmoothProgram::Values& values);

 private:
  /// Shape `a` of the arm and shape `b` of the arm, or of the obstacles.
  struct Pair {
    int a = 0;
    int b = 0;
    bool self = false;
  };
  struct Row {
    int goal = 0;
    int pair = 0;
  };
  struct ArmShape {
    const BodyGeometry* affine = nullptr;
    double greatest_radius = 0.0;  // of the ball about its origin, over all parameters
    BoundingCapsule capsule_F{};   // in the frame it moves with
  };
  /// What is known of a pair at a goal.
  struct Known {
    bool is_row = false;
    bool was_apart = false;                            // along `axis_A`
    Eigen::Vector3d axis_A = Eigen::Vector3d::Zero();  // from b to a, in the frame of shape a
  };

  struct SceneShape {
    const PlacedShape* placed = nullptr;
    double radius = 0.0;  // of the ball about its origin
    BoundingCapsule capsule;
  };
  /// Balls as arrays of numbers, which vector instructions can go through.
  struct Balls {
    std::vector<double> x, y, z, radius;
    void resize(std::size_t n);
    void set(std::size_t i, const BoundingCapsule& capsule);
  };

  void place_capsules(const Arm& arm, const Posture& posture);
  /// Whether shape `a` is `distance` or more from another shape. Remembers the direction.
  [[nodiscard]] bool measured_apart(const Arm& arm, const Posture& posture, std::size_t a, const Shape& other,
                                    const Eigen::Isometry3d& X_WO, double distance, Known& known) const;
  /// room_[i] < 0: the balls about shapes i of the arm, i >= `from`, and about `other` are farther apart than
  /// `distance`.
  void compare(const BoundingCapsule& other, std::size_t from, double distance);
  void add_gradient(const Arm& arm, const Posture& posture, const ArmMoves& order, std::span<const Move> moves,
                    GoalColumns columns, int shape, const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W,
                    bool shape_counts, Eigen::Index row, Eigen::MatrixXd& jacobian) const;

  std::vector<ArmShape> arm_shapes_;
  std::vector<SceneShape> scene_shapes_;
  std::vector<Pair> pairs_;                 // with obstacles, by obstacle; then among the arm's shapes, by the first
  std::vector<std::size_t> self_pairs_of_;  // [n_shapes + 1]: where those of a first shape begin
  std::vector<Row> rows_;
  std::vector<std::vector<Known>> known_;  // [n_goals met][n_pairs]
  // Storage that is used again.
  std::vector<BoundingCapsule> capsules_;
  Balls balls_;
  std::vector<double> room_;
};

}  // namespace modsearch::detail
