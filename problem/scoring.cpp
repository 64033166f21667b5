#include <modsearch/problem/scoring.hpp>

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace modsearch {

std::string_view name(TermId id) {
  switch (id) {
    case TermId::kReached:
      return "reached";
    case TermId::kDistance:
      return "distance";
    case TermId::kModules:
      return "module";
    case TermId::kMass:
      return "mass";
    case TermId::kCost:
      return "cost";
    case TermId::kCollision:
      return "collision";
  }
  return "";
}

// Adding 0 turns -0 into 0, which is what people expect to read.
void Terms::add(TermId id, double value) { terms_.at(size_++) = {id, value + 0.0}; }

double Terms::sum() const {
  double total = 0.0;
  for (const Term& term : items()) total += term.value;
  return total;
}

Terms Algorithm1::terms(const Facts& facts) const {
  const double n = facts.modules;
  Terms terms;
  if (facts.reached) {
    terms.add(TermId::kReached, 50.0 + 300.0 / std::exp2(n - 2.0));
  } else {
    terms.add(TermId::kDistance, -facts.relative_error);
  }
  terms.add(TermId::kModules, -2.0 * (n - 2.0));
  terms.add(TermId::kMass, -5.0 * facts.mass);
  if (facts.collides) terms.add(TermId::kCollision, -30.0);
  return terms;
}

double Algorithm1::bound(int modules, double least_mass, double least_cost) const {
  return terms({.modules = modules, .mass = least_mass, .cost = least_cost, .reached = true, .achieved = true}).sum();
}

WeightedScoring::WeightedScoring(const Weights& weights) : weights_{weights} {
  const std::pair<const char*, double> named[] = {
      {"reached", weights.reached}, {"distance", weights.distance}, {"module", weights.module},
      {"mass", weights.mass},       {"cost", weights.cost},         {"collision", weights.collision}};
  for (const auto& [key, value] : named) {
    if (!(value >= 0.0) || !std::isfinite(value)) {
      throw std::invalid_argument(fmt::format("WeightedScoring: {} is {}, not a finite number >= 0", key, value));
    }
  }
}

Terms WeightedScoring::terms(const Facts& facts) const {
  Terms terms;
  if (facts.achieved) terms.add(TermId::kReached, weights_.reached);
  if (!facts.reached) terms.add(TermId::kDistance, -weights_.distance * facts.relative_error);
  terms.add(TermId::kModules, -weights_.module * (facts.modules - 1));
  terms.add(TermId::kMass, -weights_.mass * facts.mass);
  terms.add(TermId::kCost, -weights_.cost * facts.cost);
  if (facts.collides) terms.add(TermId::kCollision, -weights_.collision);
  return terms;
}

double WeightedScoring::bound(int modules, double least_mass, double least_cost) const {
  return terms({.modules = modules, .mass = least_mass, .cost = least_cost, .reached = true, .achieved = true}).sum();
}

}  // namespace modsearch
