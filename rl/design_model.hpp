#pragma once

#include <modsearch/problem/robot_problem.hpp>
#include <modsearch/rl/action_model.hpp>

namespace modsearch {

/// What another module at the tip of a design would do, by inverse kinematics: how far the tip would still miss the
/// goals, what the whole would weigh, and both slopes in the module's parameters.
///
/// The slope of a least distance needs no derivative of the posture: where the tip p is as close to t as the joints
/// allow, d|t - p| / dx is that of p at fixed joints (the envelope theorem), and p is affine in the lengths x. Of
/// several goals the one that is missed by most beyond its tolerance counts. Collisions are not looked at.
class DesignModel final : public ActionModel {
 public:
  /// Positions within `tolerance` of p_W count [m].
  struct Target {
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
    double tolerance = 0.0;
  };

  /// Modules on the tip of `prefix` in `problem`; null unless all its goals are balls (positions within a radius).
  /// `max_joints`: no answer for longer chains. Up to three joints the least distance is exact; beyond, it is that of a
  /// fixed set of starts and costs a thousand times more.
  [[nodiscard]] static std::shared_ptr<const DesignModel> of(std::shared_ptr<const RobotProblem> problem,
                                                             const Design& prefix, int max_joints);
  /// The goals of the problem, or nothing where one of them is no ball.
  [[nodiscard]] static std::optional<std::vector<Target>> targets_of(const RobotProblem& problem);

  /// The same with other goals than those of `family`, of which only library, base pose and chains are used.
  DesignModel(std::shared_ptr<const RobotProblem> family, std::vector<Target> targets, Design prefix, int max_joints);
  /// The model whose key() was `key`. Throws std::invalid_argument for anything else.
  [[nodiscard]] static std::shared_ptr<const DesignModel> restore(std::shared_ptr<const RobotProblem> family,
                                                                  std::span<const double> key, int max_joints);

  /// Nothing for a module that does not fit the tip either: a model gradient asks for all types of a state, the masked
  /// ones too. Throws std::invalid_argument for another number of parameters.
  [[nodiscard]] std::optional<Look> look(int k, std::span<const float> x_k, Work& work) const override;
  [[nodiscard]] std::vector<double> key() const override;

 private:
  std::shared_ptr<const RobotProblem> family_;
  std::vector<Target> targets_;
  Design prefix_;
  int max_joints_;
};

}  // namespace modsearch
