#pragma once

#include <algorithm>
#include <memory>
#include <modsearch/problem/design_problem.hpp>
#include <string>
#include <vector>

namespace modsearch::testing {

/// A base and `n` types without joints that fit each other. Type k has one parameter in [0, 1] where `continuous` says
/// so, and weighs 1 + k kg.
inline std::shared_ptr<const ModuleLibrary> blocks(std::vector<bool> continuous) {
  const auto block = [](const std::string& id, const std::string& in) {
    ModuleType module;
    module.id = module.name = id;
    module.bodies.resize(1);
    module.bodies[0].id = "body";
    module.bodies[0].connectors = {{"in", {}, Gender::kFemale, in, {1.0}}, {"out", {}, Gender::kMale, "block", {1.0}}};
    return module;
  };
  std::vector<ModuleType> modules{block("base", "base")};
  for (std::size_t k = 0; k < continuous.size(); ++k) {
    modules.push_back(block("block" + std::to_string(k), "block"));
    modules.back().bodies[0].mass = AffineScalar{1.0 + static_cast<double>(k)};
    if (continuous[k]) modules.back().parameters = {{"height", "m", 0.0, 1.0}};
  }
  return std::make_shared<const ModuleLibrary>("blocks", std::move(modules));
}

/// Stacks of blocks with a value for each type: the score is the sum of the values of the types, plus the parameters,
/// less `toll` per module. Achieved where the types add up to `goal` by their index + 1. The bounds are exact for whole
/// sequences and, for prefixes, what the best type could still add.
class Stacks final : public DesignProblem {
 public:
  struct Spec {
    std::shared_ptr<const ModuleLibrary> library;
    std::vector<double> values{};
    double toll = 0.0;
    int goal = 0;
    int max_modules = 5;
    bool bounds = true;  ///< false: nothing is known beforehand
  };
  explicit Stacks(Spec spec) : spec_{std::move(spec)} {}
  [[nodiscard]] std::string name() const override { return "stacks"; }
  [[nodiscard]] const ModuleLibrary& library() const override { return *spec_.library; }
  [[nodiscard]] int max_modules() const override { return spec_.max_modules; }
  [[nodiscard]] Eigen::VectorXd context() const override { return Eigen::VectorXd::Zero(1); }
  [[nodiscard]] Optimism optimism(std::span<const int> types) const override {
    return optimism_of_prefix(types, static_cast<int>(types.size()));
  }
  [[nodiscard]] Optimism optimism_of_length(int n) const override { return optimism_of_prefix({}, n); }
  [[nodiscard]] Optimism optimism_of_prefix(std::span<const int> types, int n) const override {
    if (!spec_.bounds) return {};
    const double best = *std::max_element(spec_.values.begin(), spec_.values.end());
    double bound = -spec_.toll * n + (best + 1.0) * (n - static_cast<int>(types.size()));
    for (const int k : types) bound += value(k) + library().type(k).n_parameters();
    return {bound, ""};
  }
  [[nodiscard]] double value(int k) const { return spec_.values[static_cast<std::size_t>(k)]; }

 private:
  [[nodiscard]] Evaluation do_evaluate(const Design& design, Fidelity) const override {
    Evaluation evaluation;
    int sum = 0;
    evaluation.score = -spec_.toll * static_cast<double>(design.modules.size()) + design.parameters().sum();
    for (const int k : design.types()) {
      evaluation.score += value(k);
      sum += k + 1;
    }
    evaluation.attempt.achieved = sum == spec_.goal;
    evaluation.attempt.reached = evaluation.attempt.achieved;
    if (evaluation.attempt.achieved) evaluation.attempt.why = Failure::kNone;
    return evaluation;
  }

  Spec spec_;
};

}  // namespace modsearch::testing
