#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace modsearch {

/// What a score is made of.
struct Facts {
  int modules = 1;             ///< n, the base included
  double mass = 0.0;           ///< [kg]
  double cost = 0.0;           ///< sum of the modules' costs, the base included
  bool reached = false;
  bool achieved = false;
  bool collides = false;
  double relative_error = 0.0;  ///< |t - p| / |t - b|, mean over the goals not reached
};

enum class TermId { kReached, kDistance, kModules, kMass, kCost, kCollision };
[[nodiscard]] std::string_view name(TermId id);

/// One summand of a score.
struct Term {
  TermId id = TermId::kReached;
  double value = 0.0;
};

/// The summands of a score, in a fixed order; their sum is the score.
class Terms {
 public:
  void add(TermId id, double value);
  [[nodiscard]] double sum() const;
  [[nodiscard]] std::span<const Term> items() const { return {terms_.data(), size_}; }

 private:
  std::array<Term, 6> terms_{};
  std::size_t size_ = 0;
};

/// What a design is worth; greater is better.
class Scoring {
 public:
  virtual ~Scoring() = default;
  [[nodiscard]] virtual std::string_view name() const = 0;
  [[nodiscard]] virtual Terms terms(const Facts& facts) const = 0;
  /// No achieved design with `modules` modules (base included), at least `least_mass` kg and at least `least_cost` scores
  /// more.
  [[nodiscard]] virtual double bound(int modules, double least_mass, double least_cost) const = 0;
  /// Points that one more kilogram costs: the smooth part of the score.
  [[nodiscard]] virtual double mass_weight() const = 0;
};

/// Algorithm 1 of "Hybrid Reinforcement Learning for Modular Robot Optimization" (TU Munich, 2022): with n = #module,
/// reached: 50 + 300 / 2^(n - 2), else -|t - p| / |t - b|; then - 2 (n - 2) - 5 m, and - 30 if in collision.
class Algorithm1 final : public Scoring {
 public:
  [[nodiscard]] std::string_view name() const override { return "algorithm1"; }
  [[nodiscard]] Terms terms(const Facts& facts) const override;
  [[nodiscard]] double bound(int modules, double least_mass, double least_cost) const override;
  [[nodiscard]] double mass_weight() const override { return 5.0; }
};

/// reached [achieved] - distance [not reached] |t - p| / |t - b| - module (n - 1) - mass m - cost (sum of costs)
/// - collision [in collision].
class WeightedScoring final : public Scoring {
 public:
  struct Weights {
    double reached = 0.0;
    double distance = 0.0;
    double module = 0.0;
    double mass = 0.0;
    double cost = 0.0;
    double collision = 0.0;
  };
  /// Throws std::invalid_argument for a weight that is negative or not finite.
  explicit WeightedScoring(const Weights& weights);
  [[nodiscard]] const Weights& weights() const { return weights_; }

  [[nodiscard]] std::string_view name() const override { return "weighted"; }
  [[nodiscard]] Terms terms(const Facts& facts) const override;
  [[nodiscard]] double bound(int modules, double least_mass, double least_cost) const override;
  [[nodiscard]] double mass_weight() const override { return weights_.mass; }

 private:
  Weights weights_;
};

}  // namespace modsearch
