#pragma once

// Maxima of phi, family by family: corners (directions fixed by two segments or one disk), arcs (at right angles to one
// segment) and the open sphere.

#include <Eigen/Geometry>
#include <limits>

#include "minkowski_internal.hpp"

namespace modsearch::detail {

/// A segment counts as at right angles to n, and a disk as facing along n, below this sine; normals found within a
/// family meet it to rounding.
inline constexpr double kFlat = 1e-9;

[[nodiscard]] Eigen::Vector3d any_perpendicular(const Eigen::Vector3d& unit);

/// The best direction so far.
struct Best {
  double value = -std::numeric_limits<double>::infinity();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();

  bool offer(const Difference& d, const Eigen::Vector3d& n) {
    const double candidate = separation_along(d, n);
    if (!(candidate > value)) return false;
    value = candidate;
    normal = n;
    return true;
  }
};

/// Climbs phi on the arc of unit vectors at right angles to `g`, from `n` on it.
[[nodiscard]] Eigen::Vector3d climb_arc(const Difference& d, const Eigen::Vector3d& g, Eigen::Vector3d n);

/// Climbs phi on the whole sphere from `n`; stops early where it would end on an arc.
[[nodiscard]] Eigen::Vector3d climb_sphere(const Difference& d, Eigen::Vector3d n);

/// Offers the directions along disk axes and at right angles to two segments.
void offer_corners(const Difference& d, Best& best);

/// Offers local maxima of phi among the unit vectors at right angles to segment `i`.
void offer_arc(const Difference& d, int i, Best& best);

/// Offers maxima where the rims of two disks meet, searched from `guess`, from the best so far, from evenly spread
/// directions and, as phi bends sharply beside the axes of the disks, from between them.
void offer_rims(const Difference& d, const Eigen::Vector3d& guess, Best& best);

}  // namespace modsearch::detail
