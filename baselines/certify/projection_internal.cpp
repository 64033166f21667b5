#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/baselines/certify/projection_internal.hpp>

namespace modsearch::certify {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kParallel = 1e-20;  // square of the part of a unit normal that counts as nothing
constexpr double kTolerance = 1e-9;  // what a point may be short of a half-space, as a share of its distance from 0

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

void add_scaled(std::vector<double>& a, double scale, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += scale * b[i];
}

template <typename T>
T& at_or_new(std::vector<T>& vector, std::size_t i) {
  if (vector.size() <= i) vector.resize(i + 1);
  return vector[i];
}

}  // namespace

double Projection::split(const std::vector<double>& normal) {
  across_ = normal;
  along_.assign(n_edges_, 0.0);
  // Twice: what the first time leaves along the basis by rounding, the second takes out.
  for (int time = 0; time < 2; ++time) {
    for (std::size_t e = 0; e < n_edges_; ++e) {
      const double part = dot(basis_[e], across_);
      along_[e] += part;
      add_scaled(across_, -part, basis_[e]);
    }
  }
  return dot(across_, across_);
}

void Projection::add(std::size_t half_space, double push, double across_square) {
  const double length = std::sqrt(across_square);
  std::vector<double>& basis = at_or_new(basis_, n_edges_);
  basis = across_;
  for (double& entry : basis) entry /= length;
  std::vector<double>& parts = at_or_new(parts_, n_edges_);
  parts = along_;
  parts.push_back(length);
  at_or_new(edges_, n_edges_) = {half_space, push};
  ++n_edges_;
}

void Projection::drop(std::size_t edge, std::span<const HalfSpace> half_spaces) {
  const std::size_t n = n_edges_;
  n_edges_ = edge;  // the basis before it stays
  for (std::size_t e = edge + 1; e < n; ++e) {
    const Edge kept = edges_[e];
    const double square = split(half_spaces[kept.half_space].normal);
    add(kept.half_space, kept.push, square);
  }
}

void Projection::find_falls() {
  falls_ = along_;
  for (std::size_t e = n_edges_; e-- > 0;) {
    for (std::size_t f = e + 1; f < n_edges_; ++f) falls_[e] -= parts_[f][e] * falls_[f];
    falls_[e] /= parts_[e][e];
  }
}

bool Projection::nearest(std::span<const HalfSpace> half_spaces, const std::vector<double>& from,
                         std::vector<double>& result) {
  result = from;
  n_edges_ = 0;
  for (std::size_t steps = 10 * (half_spaces.size() + from.size()); steps > 0;) {
    // The half-space that the point is farthest out of.
    std::size_t worst = half_spaces.size();
    double shortest = -kTolerance * (1.0 + std::sqrt(dot(result, result)));
    for (std::size_t h = 0; h < half_spaces.size(); ++h) {
      const double slack = dot(half_spaces[h].normal, result) - half_spaces[h].least;
      if (slack < shortest) {
        shortest = slack;
        worst = h;
      }
    }
    if (worst == half_spaces.size()) return true;
    double push = 0.0;
    for (bool outside = true; outside && steps > 0; --steps) {
      const double across_square = split(half_spaces[worst].normal);
      find_falls();
      std::size_t blocking = n_edges_;
      double step = kInfinity;  // until an edge pushes no more
      for (std::size_t e = 0; e < n_edges_; ++e) {
        if (falls_[e] > 1e-12 && edges_[e].push / falls_[e] < step) {
          step = edges_[e].push / falls_[e];
          blocking = e;
        }
      }
      const bool free = across_square > kParallel;
      const double whole = free ? -shortest / across_square : kInfinity;
      if (step == kInfinity && whole == kInfinity) return false;
      const bool arrives = whole <= step;
      step = std::min(step, whole);
      for (std::size_t e = 0; e < n_edges_; ++e) edges_[e].push = std::max(0.0, edges_[e].push - step * falls_[e]);
      push += step;
      if (free) {
        add_scaled(result, step, across_);
        shortest += step * across_square;
      }
      if (arrives) {
        add(worst, push, across_square);
        outside = false;
      } else {
        drop(blocking, half_spaces);
      }
    }
  }
  return false;
}

}  // namespace modsearch::certify
