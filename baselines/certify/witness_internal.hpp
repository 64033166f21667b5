#pragma once

#include <modsearch/problem/robot_problem.hpp>
#include <optional>

namespace modsearch::certify {

/// A design with postures that reach every goal and are free of obstacles: what a lower bound rests on.
struct Witness {
  Design design;
  Eigen::MatrixXd postures;  ///< [n_goals x n_joints]
  double mass = 0.0;         ///< [kg]
  double score = 0.0;
};

/// The design as a witness, if its tip is within every goal at `postures` and, where the level minds, no body overlaps
/// an obstacle.
[[nodiscard]] std::optional<Witness> witness(const RobotProblem& problem, const Design& design,
                                             const Eigen::MatrixXd& postures);

/// The score of an achieved design with these types and this mass.
[[nodiscard]] double score_of(const RobotProblem& problem, std::span<const int> types, double mass);

/// What the gap of a witness is a share of: points of the score for its mass, or its score where mass costs nothing.
[[nodiscard]] double unit_of_gap(const RobotProblem& problem, const Witness& witness);

}  // namespace modsearch::certify
