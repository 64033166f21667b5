#include <modsearch/baselines/staged.hpp>

namespace modsearch {

std::optional<Evaluation> evaluate_staged(Meter& meter, const DesignProblem& problem, const Design& design,
                                          const Witness& witness) {
  if (problem.staged()) {
    std::optional<Evaluation> screen = meter.evaluate(problem, design, Fidelity::kScreen, witness);
    const bool promising = screen && (!meter.best() || screen->better_than(meter.best()->evaluation));
    if (!promising) return screen;
  }
  return meter.evaluate(problem, design, Fidelity::kFull, witness);
}

}  // namespace modsearch
