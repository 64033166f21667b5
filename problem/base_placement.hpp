#pragma once

#include <modsearch/problem/module_library.hpp>

namespace modsearch {

/// Where a base may stand: moved by x, y, z along the axes of a frame T at its nominal pose N, and turned by yaw about
/// its own z axis, each within a closed interval about 0 [m, rad].
struct BasePlacement {
  struct Interval {
    double lower = 0.0;
    double upper = 0.0;
  };
  Eigen::Isometry3d X_WN = Eigen::Isometry3d::Identity();
  Eigen::Matrix3d R_TN =
      Eigen::Matrix3d::Identity();  ///< identity: along the axes of N; R_WN: along those of the world
  Interval x{}, y{}, z{}, yaw{};

  [[nodiscard]] bool fixed() const;
};

/// `library` with a base whose place is its parameters: x, y and z, which the arm's poses are affine in like in any
/// length, and yaw, an angle; those whose interval has a width. The base becomes the first of the types (index 0) and
/// nothing else may begin a design, so that every solver and every agent places it like a module; what it stands on is
/// an empty module of its own. Assemble at placement.X_WN. Throws std::invalid_argument for intervals that are reversed
/// or not finite.
[[nodiscard]] ModuleLibrary with_placed_base(const ModuleLibrary& library, const BasePlacement& placement);

/// X_NB of a base with these `parameters` of its type in a library that with_placed_base made.
[[nodiscard]] Eigen::Isometry3d placement_of(const ModuleType& base, const Eigen::VectorXd& parameters);

}  // namespace modsearch
