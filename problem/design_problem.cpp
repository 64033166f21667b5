#include <fmt/format.h>

#include <modsearch/problem/design_problem.hpp>
#include <stdexcept>

namespace modsearch {

std::vector<int> DesignProblem::successors(std::span<const int> types) const {
  if (static_cast<int>(types.size()) + 1 >= max_modules()) return {};
  return do_successors(types);
}

Evaluation DesignProblem::evaluate(const Design& design, Fidelity fidelity, const Witness& witness) const {
  if (static_cast<int>(design.modules.size()) + 1 > max_modules()) {
    throw std::invalid_argument(fmt::format("the design has {} modules with the base, at most {} are allowed",
                                            design.modules.size() + 1, max_modules()));
  }
  check(library(), design);
  try {
    if (witness.empty()) return do_evaluate(design, fidelity);
    Evaluation with = do_evaluate_with(design, fidelity, witness);
    if (with.attempt.achieved || witness.only) return with;
    Evaluation without = do_evaluate(design, fidelity);
    const Work work = with.attempt.work;
    Evaluation& better = with.better_than(without) ? with : without;
    better.attempt.work = without.attempt.work;
    better.attempt.work += work;
    return std::move(better);
  } catch (const std::exception& error) {
    throw EvaluationError(error.what());
  }
}

Evaluation DesignProblem::do_evaluate_with(const Design& design, Fidelity fidelity, const Witness&) const {
  return do_evaluate(design, fidelity);
}

std::vector<Fidelity> DesignProblem::stages() const {
  if (staged()) return {Fidelity::kScreen, Fidelity::kFull};
  return {Fidelity::kFull};
}

std::unique_ptr<SmoothProgram> DesignProblem::relax(std::span<const int>, const Relaxation&) const { return nullptr; }

std::unique_ptr<PoseProgram> DesignProblem::pose_program(std::span<const int>) const { return nullptr; }

std::optional<Infeasibility> DesignProblem::infeasible() const { return std::nullopt; }

Optimism DesignProblem::optimism(std::span<const int>) const { return {}; }

Optimism DesignProblem::optimism_of_length(int) const { return {}; }

Optimism DesignProblem::optimism_of_prefix(std::span<const int>, int n) const { return optimism_of_length(n); }

std::vector<int> DesignProblem::do_successors(std::span<const int> types) const { return library().successors(types); }

}  // namespace modsearch
