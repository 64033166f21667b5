#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/baselines/certify/ascent_internal.hpp>

namespace modsearch::certify {

bool Ascent::project(const std::vector<double>& from, double level, std::size_t first_row,
                     std::vector<double>& result) {
  // Hildreth's method: the dual of a projection, one coordinate after the other.
  constexpr int kSweeps = 40;
  const double tolerance = 1e-4 * (1.0 + std::abs(level));
  result = from;
  const std::size_t n = from.size();
  for (std::size_t c = 0; c < n_cuts_; ++c) cuts_[c].dual = 0.0;
  duals_of_rows_.assign(n, 0.0);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double worst = 0.0;
    for (std::size_t c = 0; c < n_cuts_; ++c) {
      Cut& cut = cuts_[c];
      if (cut.square <= 1e-18) {
        if (cut.offset < level) return false;
        continue;
      }
      double value = cut.offset;
      for (std::size_t i = 0; i < n; ++i) value += cut.gradient[i] * result[i];
      worst = std::max(worst, level - value);
      const double dual = std::max(0.0, cut.dual + (level - value) / cut.square);
      const double step = dual - cut.dual;
      if (step == 0.0) continue;
      cut.dual = dual;
      for (std::size_t i = 0; i < n; ++i) result[i] += step * cut.gradient[i];
    }
    for (std::size_t i = first_row; i < n; ++i) {
      const double dual = std::max(0.0, duals_of_rows_[i] - result[i]);
      result[i] += dual - duals_of_rows_[i];
      duals_of_rows_[i] = dual;
    }
    if (worst <= tolerance) return true;
  }
  return false;
}

double Ascent::climb(NodeBound& bound, bool cap, double target, int steps, std::vector<double>& multipliers) {
  const std::size_t n = multipliers.size();
  const std::size_t first_row = n - static_cast<std::size_t>(bound.n_rows());
  double best = -std::numeric_limits<double>::infinity();
  point_ = multipliers;
  best_ = multipliers;
  n_cuts_ = 0;
  for (int step = 0; step < steps; ++step) {
    if (cuts_.size() <= n_cuts_) cuts_.emplace_back();
    Cut& cut = cuts_[n_cuts_];
    cut.gradient.resize(n);
    const double value = bound.value(point_.data(), cap, Objective::kMass, cut.gradient.data());
    if (value > best) {
      best = value;
      best_ = point_;
    }
    if (best >= target) break;
    cut.offset = value;
    cut.square = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      cut.offset -= cut.gradient[i] * point_[i];
      cut.square += cut.gradient[i] * cut.gradient[i];
    }
    ++n_cuts_;
    if (step + 1 == steps) break;
    // A little above, so that rounding and remainders do not stop short of it.
    double level = target + 0.02 * (target - best);
    bool found = false;
    for (int attempt = 0; attempt < 4 && !found; ++attempt) {
      found = project(best_, level, first_row, point_);
      level = best + 0.3 * (level - best);
    }
    if (!found) break;
    for (std::size_t i = first_row; i < n; ++i) point_[i] = std::max(0.0, point_[i]);
  }
  multipliers = best_;
  return bound.value(multipliers.data(), cap, Objective::kMass, nullptr);
}

}  // namespace modsearch::certify
