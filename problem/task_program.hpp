#pragma once

#include <memory>
#include <modsearch/kinematics/statics.hpp>
#include <modsearch/problem/robot_problem.hpp>
#include <modsearch/problem/row_sink.hpp>
#include <optional>

namespace modsearch {

/// The smooth program of a type sequence of a robot problem: least mass over (x, q per goal) such that every goal's
/// region holds, bodies keep clear of obstacles (and of each other, where the level asks for it), within all limits.
///
/// Tolerances that are a ball about the nominal (r_sph, r_cyl, Theta_R from 0) become vectors of rows within a ball,
/// which stay smooth at the nominal; all others become rows within intervals. Where the task limits torques, one row
/// per goal and joint with a peak torque: its static torque. Between neighbouring knots of a trajectory one row per
/// joint: as far as the joint may move on the way. Poses of a trajectory that are no goals of the task may be knots as
/// well (Relaxation::knots), with postures among the variables, in order. One clearance row per goal and pair of shapes
/// that do not move, the last of all rows and left out as long as the pair is far apart (SmoothProgram::grow).
///
/// An evaluation puts the arm at every goal once and allocates nothing once all rows are there.
class TaskProgram final : public SmoothProgram {
 public:
  /// `problem` must outlive the program.
  TaskProgram(const RobotProblem& problem, std::span<const int> types, const Relaxation& relaxation);
  ~TaskProgram() override;

  /// Parameters from a Halton sequence (the first: the middle of their intervals), joints by inverse kinematics for
  /// them.
  [[nodiscard]] Eigen::VectorXd start(int index) override;
  [[nodiscard]] Design design(const Eigen::VectorXd& v) const override;

 private:
  class Sink;
  struct Goals;
  /// A posture among the variables: what it is for, and the joints' way to the one before, if that is a neighbour on a
  /// trajectory.
  struct Wanted {
    PoseRegion region;
    StaticLoad load;
    std::optional<Eigen::VectorXd> way{};  // [n_joints], rad or m
  };
  struct TaskRow {
    RowSink::Row row;
  };

  void do_evaluate(const Eigen::VectorXd& v, Values& values) override;
  [[nodiscard]] Eigen::MatrixXd do_hessian(const Eigen::VectorXd& v, double objective_factor,
                                           const Eigen::VectorXd& multipliers) override;
  [[nodiscard]] int do_grow(const Eigen::VectorXd& v) override;
  void do_shrink() override;

  void add_row(double lower, double upper);
  void add_ball(int count, double radius);
  void choose_goals();
  void add_goal(int index, double margin);
  void add_torques(const Relaxation& relaxation);
  void add_ways();
  void fit_clearance_rows();
  [[nodiscard]] Eigen::Index q_at(int goal) const { return n_x_ + static_cast<Eigen::Index>(goal) * n_q_; }
  [[nodiscard]] int n_goals() const { return static_cast<int>(wanted_.size()); }
  /// Puts the arm where `v` says at every goal, unless it is there.
  void place(const Eigen::VectorXd& v);
  void torque_values(int goal, Values& values);
  void way_values(const Eigen::VectorXd& v, Values& values) const;
  void task_values(const Eigen::VectorXd& v, Values& values);

  const RobotProblem& problem_;
  Relaxation relaxation_;
  std::vector<int> types_;
  std::shared_ptr<const Chain> kept_;
  const Chain& chain_;
  Arm arm_;
  bool is_placed_ = false;
  Eigen::VectorXd placed_;  // where the arm is at all goals
  Eigen::VectorXd x_;       // storage of place()
  Eigen::Index n_x_ = 0;
  Eigen::Index n_q_ = 0;
  Eigen::VectorXd mass_gradient_;
  bool compares_bodies_ = false;
  std::vector<Wanted> wanted_;
  std::vector<int> place_of_goal_;  // in wanted_, of each goal of the task
  std::unique_ptr<Goals> goals_;
  std::vector<int> limited_joints_;  // those with a peak torque, where the task limits torques
  Eigen::Index first_torque_row_ = 0;
  Eigen::Index first_way_row_ = 0;
  std::vector<TaskRow> task_rows_;
  Eigen::RowVectorXd task_gradient_;
  Eigen::Index first_task_row_ = 0;
  Eigen::Index first_clearance_row_ = 0;  // behind all others, because their number changes
};

}  // namespace modsearch
