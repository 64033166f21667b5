#pragma once

#include <modsearch/baselines/certify/node_bound_internal.hpp>
#include <modsearch/baselines/certify/projection_internal.hpp>

namespace modsearch::certify {

/// Level bundle method on the concave bound (Lemaréchal, Nemirovskii and Nesterov 1995, "New variants of bundle
/// methods", doi:10.1007/BF01585555): the next multipliers are the nearest to the best so far at which all
/// linearisations reach the level, which is the value wanted.
class Ascent {
 public:
  /// Moves `multipliers` [n_multipliers] uphill until the bound is at least `target` or `steps` values were taken; the
  /// bound they give. The bound was last asked for these multipliers.
  double climb(NodeBound& bound, bool cap, double target, int steps, std::vector<double>& multipliers);

 private:
  // That multipliers of rows are not negative.
  void begin(std::size_t n, std::size_t first_row);
  // bound <= value + gradient_ . (multipliers - point); false: no multipliers change anything.
  bool add_linearisation(double value, const std::vector<double>& point);
  // The nearest multipliers to the best at which all linearisations reach the level; false: there are none.
  bool project(double level);

  Projection projection_;
  std::vector<HalfSpace> half_spaces_;  // first those of the rows
  std::size_t n_half_spaces_ = 0;
  std::size_t n_rows_ = 0;
  std::vector<double> offsets_, lengths_;  // of the linearisations: bound <= offset + length * normal . multipliers
  std::vector<double> best_, point_, gradient_;
};

}  // namespace modsearch::certify
