#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <Eigen/Core>

namespace modsearch::testing {

/// One module of the `seed` library in closed form, without obstacles (PROBLEM 5): the least total length that reaches a
/// target within 1 mm, by hinge and by rotary; +inf where it cannot.
struct OneModuleOptimum {
  double hinge = std::numeric_limits<double>::infinity();
  double hinge_proximal = 0.0;
  double hinge_distal = 0.0;
  double rotary = std::numeric_limits<double>::infinity();

  [[nodiscard]] double length() const { return std::min(hinge, rotary); }
  /// Algorithm 1 with n = 2: 50 + 300 - 5 m, one kilogram per metre.
  [[nodiscard]] double score() const { return 350.0 - 5.0 * length(); }
};

inline OneModuleOptimum one_module_optimum(const Eigen::Vector3d& target) {
  constexpr double kLower = 0.5;
  constexpr double kUpper = 1.5;
  constexpr double kTolerance = 1e-3;
  constexpr double kRadius = 0.055;
  OneModuleOptimum best;
  const double rho = std::hypot(target.x(), target.y());
  const double height = target.z();

  // hinge: the tip is on a circle of radius d about (0, p) in the meridional plane, so |h(p) - d| <= tolerance with
  // h(p) = hypot(rho, height - p). p + h(p) grows with p: the least p for which d can be in its interval.
  const double farthest = kUpper + kTolerance;
  const double nearest = kLower - kTolerance;
  if (rho <= farthest) {
    const double reach = std::sqrt(farthest * farthest - rho * rho);
    double p = std::max(kLower, height - reach);
    if (rho < nearest) {
      const double hole = std::sqrt(nearest * nearest - rho * rho);
      if (p > height - hole && p < height + hole) p = height + hole;
    }
    if (p <= kUpper && p <= height + reach) {
      const double d = std::clamp(std::hypot(rho, height - p) - kTolerance, kLower, kUpper);
      best.hinge = p + d;
      best.hinge_proximal = p;
      best.hinge_distal = d;
    }
  }

  // rotary: the tip is at (d - r, p + r); go towards shorter lengths by the tolerance, split evenly unless a bound is hit.
  const double diagonal = kTolerance / std::sqrt(2.0);
  const double p = std::clamp(height - kRadius - diagonal, kLower, kUpper);
  const double off_height = p + kRadius - height;
  if (std::abs(off_height) <= kTolerance) {
    const double slack = std::sqrt(kTolerance * kTolerance - off_height * off_height);
    const double d = std::max(kLower, rho + kRadius - slack);
    if (d <= kUpper && d <= rho + kRadius + slack) {
      // With d at its bound the rest of the tolerance goes to p.
      const double rest = d - kRadius - rho;
      const double p_shorter =
          std::max(kLower, height - kRadius - std::sqrt(std::max(0.0, kTolerance * kTolerance - rest * rest)));
      best.rotary = std::min(p, p_shorter) + d;
    }
  }
  return best;
}

}  // namespace modsearch::testing
