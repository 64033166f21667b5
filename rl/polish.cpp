#include <algorithm>
#include <cmath>
#include <modsearch/rl/polish.hpp>
#include <numeric>

namespace modsearch {
namespace {

using Look = ActionModel::Look;

// The shortest step that brings the linearised error to `goal` within the box: components that run into their bound
// stay there, and the others make up for them.
Eigen::VectorXd gauss_newton(const Eigen::VectorXd& x, const Look& at, double goal) {
  Eigen::VectorXd result = x;
  Eigen::VectorXd slope = at.error_slope;
  for (Eigen::Index round = 0; round < x.size(); ++round) {
    const double missing = goal - at.error - at.error_slope.dot(result - x);
    const double steepness = slope.squaredNorm();
    if (steepness <= 0.0) break;
    const Eigen::VectorXd free = result + missing / steepness * slope;
    result = free.cwiseMax(-1.0).cwiseMin(1.0);
    if (result == free) break;
    slope = (result.array() == free.array()).select(slope, 0.0);
  }
  return result;
}

// The lightest parameters whose linearised error lies within [-band, band]: all at their light ends, then moved away
// from there in the order of how much error a kilogram mends.
Eigen::VectorXd lightest(const Eigen::VectorXd& x, const Look& at, double band) {
  const Eigen::Index n = x.size();
  Eigen::VectorXd result = x;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (at.mass_slope[i] != 0.0) result[i] = at.mass_slope[i] > 0.0 ? -1.0 : 1.0;
  }
  const double error = at.error + at.error_slope.dot(result - x);
  double excess = error > band ? error - band : std::min(error + band, 0.0);  // signed: what is to be taken off

  std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  const auto cheapness = [&](Eigen::Index i) {
    return std::abs(at.error_slope[i]) / std::max(std::abs(at.mass_slope[i]), 1e-12);
  };
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return cheapness(a) > cheapness(b); });
  for (const Eigen::Index i : order) {
    if (excess == 0.0 || at.error_slope[i] == 0.0) continue;
    const double wanted = result[i] - excess / at.error_slope[i];
    const double moved = std::clamp(wanted, -1.0, 1.0);
    excess += at.error_slope[i] * (moved - result[i]);
    if (moved == wanted) excess = 0.0;
    result[i] = moved;
  }
  return result;
}

void assign(std::span<float> x_k, const Eigen::VectorXd& x) {
  for (std::size_t i = 0; i < x_k.size(); ++i) x_k[i] = static_cast<float>(x[static_cast<Eigen::Index>(i)]);
}

Eigen::VectorXd as_vector(std::span<const float> x_k) {
  return Eigen::Map<const Eigen::VectorXf>(x_k.data(), static_cast<Eigen::Index>(x_k.size()))
      .cwiseMax(-1.0F)
      .cwiseMin(1.0F)
      .cast<double>();
}

bool reaches(const Look& look) { return look.error <= look.tolerance; }

int to_the_tolerance(const ActionModel& model, int k, std::span<float> x_k, int steps, double aim, Work& work) {
  for (int step = 0; step < steps; ++step) {
    const std::optional<Look> look = model.look(k, x_k, work);
    if (!look || reaches(*look)) return step;
    const Eigen::VectorXd x = as_vector(x_k);
    const Eigen::VectorXd moved = gauss_newton(x, *look, aim * look->tolerance);
    if (moved == x) return step;
    assign(x_k, moved);
  }
  return steps;
}

int to_the_lightest(const ActionModel& model, int k, std::span<float> x_k, int steps, const PolishOptions& options,
                    Work& work) {
  std::vector<float> best;  // the lightest parameters that were seen to reach
  double best_mass = 0.0;
  int used = 0;
  for (; used <= steps; ++used) {
    const std::optional<Look> look = model.look(k, x_k, work);
    if (!look) return used;
    if (reaches(*look)) {
      if (!best.empty() && look->mass >= best_mass) break;
      best.assign(x_k.begin(), x_k.end());
      best_mass = look->mass;
    }
    if (used == steps) break;
    const Eigen::VectorXd x = as_vector(x_k);
    const bool last_chance = best.empty() && used + 1 == steps;
    const Eigen::VectorXd moved = last_chance ? gauss_newton(x, *look, options.aim * look->tolerance)
                                              : lightest(x, *look, options.edge * look->tolerance);
    if (moved == x) break;
    assign(x_k, moved);
  }
  if (!best.empty()) std::copy(best.begin(), best.end(), x_k.begin());
  return used;
}

}  // namespace

int polish(const ActionModel& model, int k, std::span<float> x_k, int steps, const PolishOptions& options, Work& work) {
  if (steps <= 0 || x_k.empty()) return 0;
  if (options.descend_mass) return to_the_lightest(model, k, x_k, steps, options, work);
  return to_the_tolerance(model, k, x_k, steps, options.aim, work);
}

}  // namespace modsearch
