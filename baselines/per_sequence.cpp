#include <modsearch/baselines/per_sequence.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <modsearch/baselines/lexicographic.hpp>
#include <modsearch/baselines/staged.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr double kImpossible = -std::numeric_limits<double>::infinity();

struct Candidate {
  std::vector<int> types;
  double bound = 0.0;
};

// Visits all type sequences of `n` modules that fit together, depth first, in order of type; stops when `visit` says so.
template <typename Visit>
bool for_each_sequence(const DesignProblem& problem, int n, std::vector<int>& prefix, const Visit& visit) {
  if (static_cast<int>(prefix.size()) == n) return visit(prefix);
  for (const int k : problem.successors(prefix)) {
    prefix.push_back(k);
    const bool go_on = for_each_sequence(problem, n, prefix, visit);
    prefix.pop_back();
    if (!go_on) return false;
  }
  return true;
}

// Sequences are sorted in lots of this many: all of them for libraries of this size, and memory stays bounded for others.
constexpr std::size_t kLot = 200'000;

}  // namespace

PerSequence::PerSequence(PerSequenceOptions options) : options_{std::move(options)} {
  if (options_.starts < 1) {
    throw std::invalid_argument(fmt::format("per-sequence: starts is {}, at least 1 is needed", options_.starts));
  }
}

std::string PerSequence::name() const {
  return fmt::format("per-sequence:inner={}", modsearch::name(options_.inner));
}

SearchEnd PerSequence::do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const {
  // The empty design is allowed and often scores more than one that misses: it stands until something better is found.
  if (!meter.evaluate(problem, Design{})) return {};

  // Numbers of modules in order of their bound; fewer first among equals.
  struct Length {
    int n;
    Optimism optimism;
  };
  std::vector<Length> lengths;
  for (int n = 1; n < problem.max_modules(); ++n) lengths.push_back({n, problem.optimism_of_length(n)});
  std::stable_sort(lengths.begin(), lengths.end(),
                   [](const Length& a, const Length& b) { return a.optimism.score > b.optimism.score; });
  const bool achieved = meter.best()->evaluation.attempt.achieved;
  if (!achieved && (lengths.empty() || lengths.front().optimism.score == kImpossible)) {
    return {StopReason::kUnreachable,
            lengths.empty() ? "no module may be attached" : lengths.back().optimism.reason,
            Bound{kImpossible, "reach"}};
  }

  std::int64_t tried = 0;
  std::int64_t possible = 0;
  std::string impossible_reason;
  bool stopped = false;
  const auto work_off = [&](std::vector<Candidate>& lot) {
    std::stable_sort(lot.begin(), lot.end(), [](const Candidate& a, const Candidate& b) { return a.bound > b.bound; });
    for (const Candidate& candidate : lot) {
      if (stopped || candidate.bound <= score_to_beat(meter)) break;
      solve_sequence(problem, candidate.types, meter, rng.fork(static_cast<std::uint64_t>(tried)));
      ++tried;
      stopped = meter.stopped().has_value();
    }
    lot.clear();
  };
  for (const Length& length : lengths) {
    if (stopped || length.optimism.score <= score_to_beat(meter)) continue;
    std::vector<Candidate> lot;
    std::vector<int> prefix;
    for_each_sequence(problem, length.n, prefix, [&](const std::vector<int>& types) {
      Optimism optimism = problem.optimism(types);
      if (optimism.score == kImpossible) {
        impossible_reason = std::move(optimism.reason);
      } else {
        ++possible;
        if (optimism.score > score_to_beat(meter)) lot.push_back({types, optimism.score});
      }
      if (lot.size() >= kLot) work_off(lot);
      stopped = stopped || meter.stopped().has_value();
      return !stopped;
    });
    work_off(lot);
  }
  if (stopped) return {};
  if (score_to_beat(meter) > kImpossible) {
    return {StopReason::kExhausted,
            fmt::format("{} type {} optimised; no other can beat the best by its bound", tried,
                        tried == 1 ? "sequence" : "sequences"),
            std::nullopt};
  }
  if (possible == 0) {
    return {StopReason::kUnreachable, impossible_reason, Bound{kImpossible, "reach"}};
  }
  return {StopReason::kExhausted,
          fmt::format("no achieved design was found in {} type sequences from {} starts each", tried, options_.starts),
          std::nullopt};
}

void PerSequence::solve_sequence(const DesignProblem& problem, std::span<const int> types, Meter& meter,
                                 Rng rng) const {
  const double bound = problem.optimism(types).score;
  // Larger and larger clearances: the first is what rounding asks for, the last more than a tolerance of 1 mm can move a
  // body of the reference library.
  constexpr std::array<double, 4> kClearances{1e-6, 1e-3, 4e-3, 1.6e-2};
  double least_achieved = std::numeric_limits<double>::infinity();  // objectives of this sequence's designs
  for (const double clearance : kClearances) {
    const std::unique_ptr<SmoothProgram> program = problem.relax(types, {.clearance_margin = clearance});
    if (!program) return;
    double least_blocked = std::numeric_limits<double>::infinity();
    for (int start = 0; start < options_.starts; ++start) {
      if (meter.stopped()) return;
      InnerOptions inner = options_.inner_options;
      // Half of the starts stay where they are feasible, half may cross the space: see InnerOptions::first_penalty.
      if (start % 2 == 0) inner.first_penalty = 1e3;
      inner.seed = rng.fork(static_cast<std::uint64_t>(start)).bits();
      const InnerResult result = minimise(options_.inner, *program, program->start(start), inner, meter);
      if (result.v.size() != program->n_variables() || !result.v.allFinite()) continue;
      const std::optional<Evaluation> evaluation = evaluate_staged(meter, problem, program->design(result.v));
      if (!evaluation) return;
      const Attempt& attempt = evaluation->attempt;
      if (attempt.achieved) least_achieved = std::min(least_achieved, result.objective);
      if (attempt.reached && !attempt.achieved) least_blocked = std::min(least_blocked, result.objective);
      // Nothing better is possible than the bound itself.
      if (attempt.achieved && evaluation->score >= bound - 1e-6) return;
    }
    // The relaxation may choose its posture within the tolerance, the score looks at the closest one: a design that is
    // lighter on paper and blocked in fact deserves another try with more room.
    if (!(least_blocked < least_achieved)) return;
  }
}

}  // namespace modsearch
