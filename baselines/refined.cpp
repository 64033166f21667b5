#include <fmt/format.h>

#include <modsearch/baselines/refined.hpp>
#include <stdexcept>
#include <utility>

namespace modsearch {

Refined::Refined(std::shared_ptr<const Solver> first, PerSequenceOptions options)
    : first_{std::move(first)}, options_{std::move(options)} {
  if (!first_) throw std::invalid_argument("refined: no solver to begin with");
  if (options_.starts < 1) {
    throw std::invalid_argument(fmt::format("refined: {} starts, at least one is needed", options_.starts));
  }
}

std::string Refined::name() const { return first_->name() + ", refined"; }

SearchEnd Refined::do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const {
  Solution found = first_->solve(problem, meter, rng);
  SearchEnd end{.stop = found.stop,
                .reason = std::move(found.reason),
                .bound = std::move(found.bound),
                .tallies = std::move(found.tallies)};
  const auto add = [&](const std::string& what) { end.reason += (end.reason.empty() ? "" : "; ") + what; };
  const bool proved = end.stop == StopReason::kOptimal || end.stop == StopReason::kUnreachable;
  const std::vector<int> types = found.design.types();
  if (proved || types.empty()) return end;
  if (meter.stopped()) {
    add("nothing of the budget is left to solve its sequence");
    return end;
  }
  const SequenceOutcome outcome =
      optimise_sequence(problem, types, problem.optimism(types).score, options_, meter, rng.fork("refinement"));
  add(!outcome.failure.empty() ? outcome.failure
      : outcome.has_program    ? fmt::format("its sequence solved from {} starts", options_.starts)
                               : "its sequence has no smooth program");
  return end;
}

}  // namespace modsearch
