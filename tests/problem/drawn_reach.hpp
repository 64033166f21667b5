#pragma once

#include <memory>
#include <modsearch/kinematics/statics.hpp>
#include <modsearch/problem/files.hpp>
#include <optional>

namespace modsearch::testing {

/// An arm of six small drives of the workshop and three full poses among the boxes of a generated task, with postures
/// that have the tip there: what a search hands over that solves for postures and lengths at once.
struct DrawnReach {
  Design design;
  Eigen::MatrixXd postures;  ///< [3 x 6]: free, and held by the drives
  std::unique_ptr<RobotProblem> problem;
};

/// The postures are the first that are free of 1000 drawn with `rng`, nothing where there are not three; `spec`: a
/// problem with the library `workshop`, whose goals become the poses there.
inline std::optional<DrawnReach> drawn_reach(RobotProblemSpec spec, Rng rng) {
  DrawnReach result;
  const ModuleLibrary& library = *spec.library;
  if (spec.placed_base) result.design.modules.push_back({0, Parameters::Zero(library.type(0).n_parameters())});
  for (const char* id : {"adapter_120_60", "drive_60_inline", "drive_60_bent", "link_60", "drive_60_bent",
                         "drive_60_inline", "drive_60_bent", "drive_60_inline", "gripper_60"}) {
    const int k = library.find(id).value();
    Parameters parameters(library.type(k).n_parameters());
    for (Eigen::Index i = 0; i < parameters.size(); ++i) {
      parameters[i] = library.type(k).parameters[static_cast<std::size_t>(i)].lower;
    }
    result.design.modules.push_back({k, parameters});
  }
  const RobotProblem before{spec};
  const std::shared_ptr<const Chain> chain = before.chain(result.design.types());
  const Arm arm = chain->at(result.design.parameters());
  result.postures.resize(3, chain->n_joints());
  std::vector<Goal> goals;
  for (int i = 0; i < 1000 && goals.size() < 3; ++i) {
    Eigen::VectorXd q(chain->n_joints());
    for (double& angle : q) angle = rng.uniform(-1.5, 1.5);
    q = chain->clamped(q);
    const Posture posture = arm.forward(q);
    Work work;
    if (spec.scene->collides(arm, posture, work) || self_collides(arm, posture, work)) continue;
    if (torque_share(*chain, static_torques(arm, posture, {})) > 1.0) continue;
    result.postures.row(static_cast<Eigen::Index>(goals.size())) = q.transpose();
    goals.push_back({std::to_string(goals.size()), GoalType::kReach, PoseRegion::with_default_tolerances(posture.tip)});
  }
  if (goals.size() < 3) return std::nullopt;
  spec.task = std::make_shared<GoalTask>("drawn", std::move(goals));
  result.problem = std::make_unique<RobotProblem>(std::move(spec));
  return result;
}

}  // namespace modsearch::testing
