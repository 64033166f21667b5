#pragma once

#include <modsearch/kinematics/pose_region.hpp>
#include <modsearch/problem/module_library.hpp>
#include <span>
#include <vector>

namespace modsearch {

/// How far one module can carry the arm and what that weighs: the tip moves away from the module's entry by at most
/// `length` + sum of length_rate * stretch, at a mass of at least `mass` + sum of mass_rate * stretch.
struct ModuleSpan {
  struct Stretch {
    double length_rate = 0.0;  ///< [m per unit of the parameter]
    double mass_rate = 0.0;    ///< [kg per unit]
    double range = 0.0;        ///< upper - lower
  };
  double length = 0.0;  ///< stretched out, parameters at their lower ends [m]
  double mass = 0.0;    ///< least mass within the box, but for the stretches counted in `stretches` [kg]
  double cost = 0.0;
  std::vector<Stretch> stretches{};

  [[nodiscard]] double greatest_length() const;
  /// Most length per kilogram of any stretch [m/kg]; 0: none lengthens.
  [[nodiscard]] double best_rate() const;
};

/// The span of a module type between its two connectors, by the triangle inequality over its rigid pieces.
[[nodiscard]] ModuleSpan module_span(const ModuleType& module);

/// How far from the nominal position a position of the region can be at most [m]; +inf if unbounded.
[[nodiscard]] double position_slack(const PoseRegion& region);

/// What the triangle inequality says about reaching something with certain modules.
struct ReachBound {
  bool possible = true;     ///< false: proved that no parameters and no posture get there
  double span = 0.0;        ///< longest stretched arm [m]
  double least_mass = 0.0;  ///< no parameters that get there weigh less [kg]
};

/// Arms of exactly these modules whose tip has to be `distance` [m] away from the base. The tip is never farther away
/// than the arm is long; the lightest parameters that are long enough come from a fractional knapsack, because length
/// and mass are affine in them.
[[nodiscard]] ReachBound reach_bound(std::span<const ModuleSpan* const> modules, double distance);

/// What is known of modules that an arm goes on with, whichever they are.
struct Continuation {
  bool possible = true;          ///< false: there are none
  double length = 0.0;           ///< sum of ModuleSpan::length at most [m]
  double greatest_length = 0.0;  ///< sum of ModuleSpan::greatest_length() at most [m]
  double mass = 0.0;             ///< sum of ModuleSpan::mass at least [kg]
  double cost = 0.0;             ///< at least
  double best_rate = 0.0;        ///< most length per kilogram of their stretches [m/kg]
};
/// Any `more` of `types`.
[[nodiscard]] Continuation any_of_types(std::span<const ModuleSpan> types, int more);

/// Arms of these modules and of others of which no more is known than `rest`.
[[nodiscard]] ReachBound reach_bound(std::span<const ModuleSpan* const> modules, const Continuation& rest,
                                     double distance);

/// Arms of these modules and any `more` of `types`: weaker, but covers all continuations of that length at once.
[[nodiscard]] ReachBound reach_bound(std::span<const ModuleSpan* const> modules, std::span<const ModuleSpan> types,
                                     int more, double distance);

}  // namespace modsearch
