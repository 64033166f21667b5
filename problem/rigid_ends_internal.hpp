#pragma once

// What stands before the first joint of an arm and behind its last one, module by module. Internal to the problem
// floor.

#include <modsearch/problem/module_library.hpp>
#include <vector>

namespace modsearch::detail {

/// A collision shape that a reference frame R carries along, placed by parameters alone.
struct RigidPart {
  AffineShape shape;
  ParametricPose X_RG;
};

/// A module at a rigid end of an arm, seen from the frame R at that end. Modules form trees, from the end inwards: one
/// that is rigid itself carries what joins it.
struct RigidModule {
  static constexpr int kBase = -1;

  int type = kBase;                ///< of the library
  int outer = -1;                  ///< the module between this one and R, an index into the same tree; -1: none
  std::vector<int> inner{};        ///< those that may join it on the other side; only where all of them are there
  bool extended = false;           ///< `inner` was filled: whatever arm has this module here goes on with one of these
  bool whole_arm = false;          ///< in a tail: the base may come next, and the arm then has no joint
  std::vector<RigidPart> parts{};  ///< of this module, rigid with R
  Eigen::VectorXd lower{};  ///< box of the parameters of this module, behind those of the modules between it and R
  Eigen::VectorXd upper{};
};

/// The rigid ends of all arms of a library, as far as a few modules.
struct RigidEnds {
  /// R is the tip. The first `n_last` are the modules that a complete design may end with; where the library has no end
  /// effectors, the base is the last of these: a design may have no module at all.
  std::vector<RigidModule> tails;
  int n_last = 0;
  /// R is where the base stands; the first is the base itself.
  std::vector<RigidModule> heads;
};

[[nodiscard]] RigidEnds rigid_ends(const ModuleLibrary& library);

}  // namespace modsearch::detail
