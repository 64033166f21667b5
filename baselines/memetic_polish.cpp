#include <algorithm>
#include <exception>
#include <modsearch/baselines/memetic_polish.hpp>

namespace modsearch {

namespace {

std::optional<Design> minimised(const DesignProblem& problem, const Design& design, double clearance, Inner inner,
                                Meter& meter, int iterations) {
  const std::vector<int> types = design.types();
  const std::unique_ptr<SmoothProgram> program = problem.relax(types, {.clearance_margin = clearance});
  if (!program) return std::nullopt;
  const std::optional<Evaluation> evaluation = meter.evaluate(problem, design, Fidelity::kScreen);
  if (!evaluation) return std::nullopt;

  const Eigen::VectorXd x = design.parameters();
  const Eigen::MatrixXd& postures = evaluation->attempt.postures;
  Eigen::VectorXd start = program->start(0);
  if (x.size() + postures.size() == start.size()) {
    start.head(x.size()) = x;
    for (Eigen::Index goal = 0; goal < postures.rows(); ++goal) {
      start.segment(x.size() + goal * postures.cols(), postures.cols()) = postures.row(goal);
    }
    start = start.cwiseMax(program->lower()).cwiseMin(program->upper());
  }
  // A design that reaches is to stay where it is; one that misses may cross the space (InnerOptions::first_penalty).
  InnerOptions options{.max_iterations = iterations};
  if (evaluation->attempt.reached) options.first_penalty = 1e3;
  const InnerResult result = minimise(inner, *program, start, options, meter);
  if (result.v.size() != program->n_variables() || !result.v.allFinite()) return std::nullopt;
  return program->design(result.v);
}

}  // namespace

std::optional<Design> polished(const DesignProblem& problem, const Design& design, double clearance, Inner inner,
                               Meter& meter, int iterations) {
  try {
    return minimised(problem, design, clearance, inner, meter, iterations);
  } catch (const std::exception&) {
    return std::nullopt;  // a user's program that throws ends this polish, not the search
  }
}

}  // namespace modsearch
