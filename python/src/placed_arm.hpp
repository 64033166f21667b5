#pragma once

#include <memory>
#include <modsearch/problem/robot_problem.hpp>

namespace modsearch::python {

/// An arm with what it needs to stay alive, and the problem it stands in.
struct PlacedArm {
  std::shared_ptr<const Chain> chain;
  Arm arm;
  std::shared_ptr<const RobotProblem> problem{};  ///< null: of a library alone, without goals and obstacles
};

/// The arm of `design` in `problem`. Throws std::invalid_argument for a design outside the search space.
[[nodiscard]] PlacedArm placed_arm(std::shared_ptr<const RobotProblem> problem, const Design& design);
/// The arm of `design`, its base at `X_WB`, with nothing around it.
[[nodiscard]] PlacedArm placed_arm(const ModuleLibrary& library, const Design& design, const Eigen::Isometry3d& X_WB);

}  // namespace modsearch::python
