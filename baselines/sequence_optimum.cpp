#include <algorithm>
#include <array>
#include <limits>
#include <modsearch/baselines/sequence_optimum.hpp>
#include <modsearch/baselines/staged.hpp>
#include <utility>

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class SequenceOptimiser {
 public:
  SequenceOptimiser(const DesignProblem& problem, std::span<const int> types, double bound,
                    const PerSequenceOptions& options, Meter& meter, Rng rng)
      : problem_{problem}, types_{types}, bound_{bound}, options_{options}, meter_{meter}, rng_{rng} {}

  [[nodiscard]] SequenceOutcome run() {
    // Larger and larger clearances: the first is what rounding asks for, the last more than a tolerance of 1 mm can
    // move a body of the reference library.
    constexpr std::array<double, 4> kClearances{1e-6, 1e-3, 4e-3, 1.6e-2};
    SequenceOutcome outcome;
    try {
      for (const double clearance : kClearances) {
        const std::unique_ptr<SmoothProgram> program = problem_.relax(types_, {.clearance_margin = clearance});
        outcome.has_program = program != nullptr;
        if (!program || !solve(*program)) break;
      }
      if (refused_) follow_closer();
    } catch (const std::exception& error) {
      outcome = {.has_program = true, .failure = error.what()};
    }
    if (outcome.failure.empty() && solves_ > 0 && failed_solves_ == solves_) {
      outcome.failure = "the smooth program is not a number";
    }
    return outcome;
  }

 private:
  // A trajectory has few knots in the program and many poses in fact. Between the knots of a feasible program the arm
  // may leave the tolerance: more and more knots, and room for what happens between them.
  void follow_closer() {
    constexpr std::array<int, 4> kKnots{16, 32, 64, 128};
    // Half a millimetre or milliradian, of tolerances of some millimetres: with 37 of the 73 poses of a circle of
    // radius 0.2 m the arm leaves its tolerance by up to 0.4 mm between them.
    constexpr double kMargin = 5e-4;
    for (const int knots : kKnots) {
      const std::unique_ptr<SmoothProgram> program =
          problem_.relax(types_, {.tolerance_margin = kMargin, .clearance_margin = kMargin, .knots = knots});
      // No trajectory, or no more poses of it: this is the program that was solved.
      if (!program || program->n_variables() == std::exchange(solved_variables_, program->n_variables())) return;
      (void)solve(*program);
      if (least_achieved_ < kInfinity || meter_.stopped()) return;
    }
  }

  // From every start; whether another try with more clearance may help.
  [[nodiscard]] bool solve(SmoothProgram& program) {
    double least_blocked = kInfinity;
    solved_variables_ = program.n_variables();
    for (int start = 0; start < options_.starts; ++start) {
      if (meter_.stopped()) return false;
      InnerOptions inner = options_.inner_options;
      // Half of the starts stay where they are feasible, half may cross the space: see InnerOptions::first_penalty.
      if (start % 2 == 0) inner.first_penalty = 1e3;
      inner.seed = rng_.fork(static_cast<std::uint64_t>(start)).bits();
      const InnerResult result = minimise(options_.inner, program, program.start(start), inner, meter_);
      ++solves_;
      if (result.status == InnerStatus::kFailed) ++failed_solves_;
      if (result.v.size() != program.n_variables() || !result.v.allFinite()) continue;
      const std::optional<Evaluation> evaluation = evaluate_staged(meter_, problem_, program.design(result.v));
      if (!evaluation) return false;
      const Attempt& attempt = evaluation->attempt;
      if (attempt.achieved) least_achieved_ = std::min(least_achieved_, result.objective);
      if (!attempt.reached && result.violation <= inner.tolerance) refused_ = true;
      if (attempt.reached && !attempt.achieved) least_blocked = std::min(least_blocked, result.objective);
      // Nothing better is possible than the bound itself.
      if (attempt.achieved && evaluation->score >= bound_ - 1e-6) return false;
    }
    // The relaxation may choose its posture within the tolerance, the score looks at the closest one: a design that is
    // lighter on paper and blocked in fact deserves another try with more room.
    return least_blocked < least_achieved_;
  }

  const DesignProblem& problem_;
  std::span<const int> types_;
  double bound_;
  const PerSequenceOptions& options_;
  Meter& meter_;
  Rng rng_;
  double least_achieved_ = kInfinity;  // objectives of this sequence's designs
  int solved_variables_ = 0;           // of the program that was solved last
  bool refused_ = false;               // a feasible program's design does not meet the poses in fact
  int solves_ = 0;
  int failed_solves_ = 0;
};

}  // namespace

SequenceOutcome optimise_sequence(const DesignProblem& problem, std::span<const int> types, double bound,
                                  const PerSequenceOptions& options, Meter& meter, Rng rng) {
  return SequenceOptimiser{problem, types, bound, options, meter, rng}.run();
}

}  // namespace modsearch
