#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/baselines/certify/ascent_internal.hpp>

namespace modsearch::certify {
namespace {

constexpr double kAbove = 1e-6;  // share of the target

}  // namespace

void Ascent::begin(std::size_t n, std::size_t first_row) {
  n_rows_ = n - first_row;
  n_half_spaces_ = n_rows_;
  if (half_spaces_.size() < n_rows_) half_spaces_.resize(n_rows_);
  for (std::size_t r = 0; r < n_rows_; ++r) {
    half_spaces_[r].normal.assign(n, 0.0);
    half_spaces_[r].normal[first_row + r] = 1.0;
    half_spaces_[r].least = 0.0;
  }
  offsets_.clear();
  lengths_.clear();
}

bool Ascent::add_linearisation(double value, const std::vector<double>& point) {
  double offset = value;
  double square = 0.0;
  for (std::size_t i = 0; i < point.size(); ++i) {
    offset -= gradient_[i] * point[i];
    square += gradient_[i] * gradient_[i];
  }
  if (square <= 1e-18) return false;
  if (half_spaces_.size() == n_half_spaces_) half_spaces_.emplace_back();
  std::vector<double>& normal = half_spaces_[n_half_spaces_++].normal;
  normal = gradient_;
  offsets_.push_back(offset);
  lengths_.push_back(std::sqrt(square));
  for (double& entry : normal) entry /= lengths_.back();
  return true;
}

bool Ascent::project(double level) {
  for (std::size_t c = 0; c < offsets_.size(); ++c)
    half_spaces_[n_rows_ + c].least = (level - offsets_[c]) / lengths_[c];
  return projection_.nearest({half_spaces_.data(), n_half_spaces_}, best_, point_);
}

double Ascent::climb(NodeBound& bound, bool cap, double target, int steps, std::vector<double>& multipliers) {
  const std::size_t n = multipliers.size();
  const std::size_t first_row = n - static_cast<std::size_t>(bound.n_rows());
  double best = -std::numeric_limits<double>::infinity();
  point_ = multipliers;
  best_ = multipliers;
  gradient_.resize(n);
  begin(n, first_row);
  for (int step = 0; step < steps; ++step) {
    const double value = bound.value(point_.data(), cap, Objective::kMass, gradient_.data());
    if (value > best) {
      best = value;
      best_ = point_;
    }
    if (best >= target || step + 1 == steps || !add_linearisation(value, point_)) break;
    // A little above, so that rounding and remainders do not stop short of it.
    double level = target + std::max(0.02 * (target - best), kAbove * (1.0 + std::abs(target)));
    bool found = false;
    for (int attempt = 0; attempt < 4 && !found; ++attempt) {
      found = project(level);
      level = best + 0.3 * (level - best);
    }
    if (!found) break;
    for (std::size_t i = first_row; i < n; ++i) point_[i] = std::max(0.0, point_[i]);
  }
  multipliers = best_;
  return bound.value(multipliers.data(), cap, Objective::kMass, nullptr);
}

}  // namespace modsearch::certify
