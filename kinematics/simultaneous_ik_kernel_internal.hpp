#pragma once

#include <cstddef>

// What the kernels of all instruction sets have in common. Sources compiled for a wide instruction set include this
// header and no other: an inline function of a library, compiled for it here, could be the copy that the linker keeps
// for the whole program. For the same reason the functions below are static.
namespace modsearch::detail {

/// Starts that a kernel works on at once: the doubles of the widest vector.
inline constexpr int kIkLanes = 8;

/// A part of a number or a vector that grows with a parameter.
struct IkTerm {
  int parameter = 0;
  double scale = 0.0;           ///< of an angle [rad per unit]
  double direction[3] = {0.0};  ///< of a translation [m per unit]
};

/// One step along the chain, from the base outwards.
struct IkLink {
  enum class Kind : int {
    kRigid,  ///< a fixed rotation and a translation that parameters may shift
    kTwist,  ///< a turn about z by an angle affine in the parameters
    kTurn,   ///< a joint about z
    kSlide,  ///< a joint along z
  };
  Kind kind = Kind::kRigid;
  int joint = 0;               ///< kTurn, kSlide: which
  bool rotates = false;        ///< kRigid: the rotation is not the identity
  double rotation[9] = {0.0};  ///< kRigid, row by row
  double offset[3] = {0.0};    ///< kRigid: translation without the parameters' part [m]; kTwist: [0] is the angle [rad]
  int first_term = 0;          ///< in IkModel::terms
  int n_terms = 0;
};

/// What a goal asks of the tip, as six rows: position in its frame T, rotation in its frame S.
struct IkTarget {
  double position[3] = {0.0};   ///< of the nominal pose, world [m]
  double rotation[9] = {0.0};   ///< R_WN, row by row
  bool whole_position = false;  ///< all three rows of the position count alike and without slack: frames do not matter
  bool whole_rotation = false;
  double R_TW[9] = {0.0};  ///< world axes to those of the position's rows
  double R_SW[9] = {0.0};  ///< world axes to those of the rotation's rows
  /// Rows of the position, then of the rotation: does it count, and how far from the nominal [m or rad] it costs
  /// nothing.
  double weight[6] = {0.0};
  double lower[6] = {0.0};
  double upper[6] = {0.0};
};

/// One arm, all its goals.
struct IkModel {
  int n_parameters = 0;
  int n_joints = 0;
  int n_goals = 0;
  int n_links = 0;
  const IkLink* links = nullptr;
  const IkTerm* terms = nullptr;
  const IkTarget* targets = nullptr;
  const double* lower = nullptr;  ///< [n_variables]: parameters, then joints goal by goal
  const double* upper = nullptr;
  double length = 0.25;  ///< a radian of rotation counts as much as this many metres
};
[[nodiscard]] static constexpr int ik_variables(const IkModel& m) { return m.n_parameters + m.n_goals * m.n_joints; }

/// Where the lanes stand. Pointers to arrays [.. x kIkLanes], aligned to 64 bytes.
struct IkLanes {
  double* v = nullptr;         ///< [n_variables]
  double* cost = nullptr;      ///< [1] half the sum of squares at v; +inf: nothing is known of v yet
  double* damping = nullptr;   ///< [1]
  double* position = nullptr;  ///< [n_goals] squared distance from what is asked [m^2]
  double* rotation = nullptr;  ///< [n_goals] 1 - cos(angle) of what is asked
  double* normal = nullptr;    ///< normal equations at v, see `IkKernel::normal_size`
  double* work = nullptr;      ///< see `IkKernel::work_size`
};

/// One instruction set's version.
struct IkKernel {
  /// One damped step of every lane: taken where it lowers the cost, else the damping grows.
  void (*step)(const IkModel&, const IkLanes&) = nullptr;
};

/// Vectors in `IkLanes::normal`: gradient, diagonal blocks of the goals' joints, their coupling to the parameters, the
/// parameters' block; the blocks as lower triangles, row by row.
[[nodiscard]] static constexpr std::size_t ik_triangle(int n) {
  return static_cast<std::size_t>(n) * (static_cast<std::size_t>(n) + 1) / 2;
}
[[nodiscard]] static constexpr std::size_t ik_normal_size(const IkModel& m) {
  const auto goals = static_cast<std::size_t>(m.n_goals);
  const auto coupling = static_cast<std::size_t>(m.n_joints) * static_cast<std::size_t>(m.n_parameters);
  return static_cast<std::size_t>(ik_variables(m)) + goals * (ik_triangle(m.n_joints) + coupling) +
         ik_triangle(m.n_parameters);
}
/// Vectors in `IkLanes::work`: trial point, its normal equations, cost and errors, a factor of the normal equations,
/// the columns of a Jacobian, axes and origins along the chain.
[[nodiscard]] static constexpr std::size_t ik_work_size(const IkModel& m) {
  const auto n = static_cast<std::size_t>(ik_variables(m));
  const auto columns = static_cast<std::size_t>(m.n_joints + m.n_parameters);
  return 3 * n + 2 * ik_normal_size(m) + 6 * columns + 2 * static_cast<std::size_t>(m.n_goals) +
         12 * (static_cast<std::size_t>(m.n_links) + 1) + 8;
}

extern const IkKernel kIkKernelSse2;
extern const IkKernel kIkKernelAvx2;
extern const IkKernel kIkKernelAvx512;

}  // namespace modsearch::detail
