#pragma once

#include <Eigen/Core>
#include <modsearch/kinematics/work.hpp>
#include <optional>
#include <span>
#include <vector>

namespace modsearch {

/// What is known of an action's outcome without taking it: how far it would miss, what it would add, and the exact
/// derivatives of both in the action's own parameters. Belongs to one state of one environment and stays valid after
/// the environment has moved on. Immutable, safe to share between threads.
class ActionModel {
 public:
  /// At (k, x_k), x_k scaled to [-1, 1].
  struct Look {
    double error = 0.0;            ///< distance from the goal(s) [m]; at most `tolerance` where they are reached
    double tolerance = 0.0;        ///< [m]
    double mass = 0.0;             ///< of the whole [kg]
    Eigen::VectorXd error_slope;   ///< d error / d x_k [n_k], m per unit of x
    Eigen::VectorXd mass_slope;    ///< d mass / d x_k [n_k], kg per unit of x
  };

  virtual ~ActionModel() = default;
  /// Nothing where the model has no answer (a goal without a distance, too many joints for an exact one).
  [[nodiscard]] virtual std::optional<Look> look(int k, std::span<const float> x_k, Work& work) const = 0;
  /// The model as numbers, from which Environment::restore_model builds it again: for checkpoints.
  [[nodiscard]] virtual std::vector<double> key() const = 0;
};

}  // namespace modsearch
