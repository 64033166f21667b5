#pragma once

#include <filesystem>
#include <modsearch/problem/design.hpp>
#include <string>

namespace modsearch {

/// What a URDF is written with.
struct UrdfOptions {
  std::string name = "arm";                                ///< of the robot
  std::filesystem::path folder = ".";                      ///< the file will lie here: meshes are named relative to it
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();  ///< pose of the base in the link `world`
};

/// The arm of `design`, lengths and twists frozen, as a URDF (wiki.ros.org/urdf/XML): links `world`, `base_link`,
/// `link_1` .. `link_n`, one for all bodies that move with a joint, and `tcp` at the tip.
///
/// Links have collision and visual geometry, and the inertia of their bodies, made physical where the library has none;
/// a link that weighs nothing has no inertial. Joints keep limits, effort, velocity, damping and friction; where the
/// library sets no effort or velocity, 1e9 stands for it. What URDF has no place for (acceleration, gear ratio, motor
/// inertia, and which bodies are never compared) is left out. Throws std::invalid_argument if the design does not
/// belong to the library.
[[nodiscard]] std::string to_urdf(const ModuleLibrary& library, const Design& design, const UrdfOptions& options = {});

}  // namespace modsearch
