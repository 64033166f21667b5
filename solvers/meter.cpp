#include <cmath>
#include <modsearch/solvers/meter.hpp>
#include <stdexcept>
#include <utility>

namespace modsearch {
namespace {

// NaN compares false with everything: left alone, it would be neither better nor worse than any other score.
void refuse_nan(Evaluation& evaluation) {
  evaluation.score = -std::numeric_limits<double>::infinity();
  evaluation.attempt.achieved = false;
  evaluation.attempt.why = Failure::kNotANumber;
}

}  // namespace

std::string_view name(StopReason reason) {
  switch (reason) {
    case StopReason::kEvaluations:
      return "evaluations";
    case StopReason::kSeconds:
      return "seconds";
    case StopReason::kTargetScore:
      return "target score";
    case StopReason::kInterrupted:
      return "interrupted";
    case StopReason::kOptimal:
      return "optimal";
    case StopReason::kUnreachable:
      return "unreachable";
    case StopReason::kExhausted:
      return "exhausted";
  }
  throw std::invalid_argument("name: no such StopReason");
}

Meter::Meter(Budget budget, Observer observer, std::stop_token stop)
    : budget_{budget},
      observer_{std::move(observer)},
      stop_{std::move(stop)},
      start_{std::chrono::steady_clock::now()} {
  if (budget_.evaluations < 0 || !(budget_.seconds >= 0.0) || std::isnan(budget_.target_score)) {
    throw std::invalid_argument("Meter: a budget must be at least 0 and a number");
  }
}

std::optional<Evaluation> Meter::evaluate(const DesignProblem& problem, const Design& design, Fidelity fidelity) {
  if (stopped()) return std::nullopt;
  ++progress_.evaluations;  // before the call: an evaluation that throws was paid for too
  Evaluation evaluation = problem.evaluate(design, fidelity);
  progress_.work += evaluation.attempt.work;
  if (std::isnan(evaluation.score)) {
    ++progress_.failed;
    refuse_nan(evaluation);
  }
  if (fidelity == Fidelity::kFull && (!best_ || evaluation.better_than(best_->evaluation))) {
    best_ = Incumbent{design, evaluation};
    trace_.push_back({progress_.evaluations, elapsed(), evaluation.score, evaluation.attempt.achieved});
  }
  if (observer_) observer_(*this);
  return evaluation;
}

void Meter::count_program(std::int64_t evaluations) {
  const std::int64_t before = progress_.program_evaluations;
  progress_.program_evaluations += evaluations;
  constexpr std::int64_t kPeriod = 4096;  // some milliseconds of typical programs
  if (observer_ && before / kPeriod != progress_.program_evaluations / kPeriod) observer_(*this);
}

std::optional<StopReason> Meter::stopped() const {
  if (best_ && best_->evaluation.attempt.achieved && best_->evaluation.score >= budget_.target_score) {
    return StopReason::kTargetScore;
  }
  if (stop_.stop_requested()) return StopReason::kInterrupted;
  if (progress_.evaluations >= budget_.evaluations) return StopReason::kEvaluations;
  // Reading the clock costs more than all of the above: only where somebody asked for it.
  if (std::isfinite(budget_.seconds) && elapsed() >= budget_.seconds) return StopReason::kSeconds;
  return std::nullopt;
}

Progress Meter::progress() const {
  Progress progress = progress_;
  progress.seconds = elapsed();
  return progress;
}

double Meter::elapsed() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

}  // namespace modsearch
