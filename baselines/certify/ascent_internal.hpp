#pragma once

#include <modsearch/baselines/certify/node_bound_internal.hpp>

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
  struct Cut {
    std::vector<double> gradient;
    double offset = 0.0;  // bound <= offset + gradient . multipliers
    double square = 0.0;
    double dual = 0.0;
  };
  // The nearest point to `from` above `level` in all cuts, at nonnegative row multipliers; false: there is none.
  bool project(const std::vector<double>& from, double level, std::size_t first_row, std::vector<double>& result);

  std::vector<Cut> cuts_;
  std::size_t n_cuts_ = 0;
  std::vector<double> best_, point_, duals_of_rows_;
};

}  // namespace modsearch::certify
