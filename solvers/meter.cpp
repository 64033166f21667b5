#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/kinematics/interruption.hpp>
#include <modsearch/solvers/meter.hpp>
#include <modsearch/solvers/search.hpp>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace modsearch {
namespace {

// What no search comes to; a checkpoint that holds more was not written by one, and sums would overflow.
constexpr std::int64_t kMostCounted = std::int64_t{1} << 53U;
constexpr double kMostSeconds = 3e9;  // a century
bool is_count(std::int64_t number) { return number >= 0 && number <= kMostCounted; }

// The score of `design`, or the worst there is where the problem fails; then `what` says what it had to say.
// NaN compares false with everything: left alone, it would be neither better nor worse than any other score.
Evaluation evaluated(const DesignProblem& problem, const Design& design, Fidelity fidelity, const Witness& witness,
                     std::optional<std::string>& what) {
  const auto refuse = [&](Evaluation& evaluation, Failure why, const char* words) {
    evaluation.score = -std::numeric_limits<double>::infinity();
    evaluation.attempt.achieved = false;
    evaluation.attempt.why = why;
    evaluation.attempt.inconclusive = true;
    what = words;
  };
  try {
    Evaluation evaluation = problem.evaluate(design, fidelity, witness);
    if (std::isnan(evaluation.score)) refuse(evaluation, Failure::kNotANumber, "the score is not a number");
    return evaluation;
  } catch (const EvaluationError& error) {
    Evaluation evaluation{};
    refuse(evaluation, Failure::kThrew, error.what());
    return evaluation;
  }
}

// How near a design that is not achieved came; larger is nearer.
auto nearness(const Attempt& attempt) {
  const double spare = attempt.why == Failure::kTorque ? -attempt.torque_share : attempt.clearance;
  return std::tuple{attempt.why != Failure::kIncomplete, -attempt.relative_error, static_cast<int>(attempt.why), spare};
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

std::optional<Evaluation> Meter::evaluate(const DesignProblem& problem, const Design& design, Fidelity fidelity,
                                          const Witness& witness) {
  if (stopped()) return std::nullopt;
  ++progress_.evaluations;  // before the call: an evaluation that throws was paid for too
  std::optional<std::string> failure;
  Evaluation evaluation;
  try {
    const Interruptible scope{[this] { return cut_off(); }};
    evaluation = evaluated(problem, design, fidelity, witness, failure);
  } catch (const Interrupted&) {
    --progress_.evaluations;
    return std::nullopt;
  }
  if (failure && progress_.failed++ == 0) first_failure_ = *failure;
  const Failure why = evaluation.attempt.achieved ? Failure::kNone : evaluation.attempt.why;
  ++progress_.outcomes[static_cast<std::size_t>(why)];
  if (!evaluation.attempt.achieved && evaluation.attempt.inconclusive) ++progress_.inconclusive;
  progress_.work += evaluation.attempt.work;
  if (fidelity == Fidelity::kFull && (!best_ || evaluation.better_than(best_->evaluation))) {
    best_ = Incumbent{design, evaluation};
    trace_.push_back({progress_.evaluations, elapsed(), evaluation.score, evaluation.attempt.achieved});
  }
  remember_nearest(design, evaluation);
  if (observer_) observer_(*this);
  return evaluation;
}

void Meter::remember_nearest(const Design& design, const Evaluation& evaluation) {
  const Attempt& attempt = evaluation.attempt;
  if (best_ && best_->evaluation.attempt.achieved) {
    nearest_.reset();
    return;
  }
  // A screening that passes has missed nothing, and a failure of the problem itself says nothing about the design. The
  // comparison refuses what is not a number, with which no other could ever compare.
  const bool missed = !attempt.achieved && attempt.why != Failure::kNotANumber && attempt.why != Failure::kThrew &&
                      attempt.relative_error >= 0.0;
  if (!missed || (nearest_ && nearness(attempt) <= nearness(nearest_->evaluation.attempt))) return;
  nearest_ = Incumbent{design, evaluation};
}

void Meter::say(std::string stage) {
  stage_ = std::move(stage);
  if (observer_) observer_(*this);
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

void Meter::save(Archive& archive) const {
  const Progress p = progress();
  archive.put("meter/counts", std::array<std::int64_t, 8>{p.evaluations, p.failed, p.program_evaluations,
                                                          p.work.forward, p.work.ik_iterations, p.work.distances,
                                                          p.work.planner_states, p.inconclusive});
  archive.put("meter/outcomes", p.outcomes);
  archive.put_number("meter/seconds", p.seconds);
  archive.put_text("meter/first failure", first_failure_);
  std::vector<double> trace;
  for (const TracePoint& point : trace_) {
    trace.insert(trace.end(),
                 {static_cast<double>(point.evaluations), point.seconds, point.score, point.achieved ? 1.0 : 0.0});
  }
  archive.put("meter/trace", std::span<const double>{trace});
  if (nearest_) put(archive, "meter/nearest", std::span{&nearest_->design, 1});
  if (!best_) return;
  put(archive, "meter/best", std::span{&best_->design, 1});
  put(archive, "meter/best/postures", best_->evaluation.attempt.postures);
}

void Meter::restore(const Archive& archive, const DesignProblem& problem) {
  const std::vector<std::int64_t> counts = archive.integers("meter/counts");
  // A checkpoint of an earlier version does not tell: then any of them may have been.
  if (counts.size() != 7 && counts.size() != 8) archive.fail("meter/counts", "does not hold 8 numbers");
  if (!std::all_of(counts.begin(), counts.end(), is_count)) archive.fail("meter/counts", "holds what is no count");
  progress_ = {
      .evaluations = counts[0],
      .failed = counts[1],
      .inconclusive = counts.size() == 8 ? counts[7] : counts[0],
      .program_evaluations = counts[2],
      .work = {.forward = counts[3], .ik_iterations = counts[4], .distances = counts[5], .planner_states = counts[6]}};
  const std::vector<std::int64_t> outcomes = archive.integers("meter/outcomes");
  if (outcomes.size() != kFailures) archive.fail("meter/outcomes", "does not hold one number per outcome");
  if (!std::all_of(outcomes.begin(), outcomes.end(), is_count))
    archive.fail("meter/outcomes", "holds what is no count");
  std::copy(outcomes.begin(), outcomes.end(), progress_.outcomes.begin());
  const double seconds = archive.number("meter/seconds");
  if (!(seconds >= 0.0 && seconds <= kMostSeconds)) {
    archive.fail("meter/seconds", fmt::format("is {} (limit: [0, {}])", seconds, kMostSeconds));
  }
  start_ = std::chrono::steady_clock::now() -
           std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(seconds));
  first_failure_ = archive.text("meter/first failure");
  const std::vector<double> trace = archive.numbers("meter/trace");
  if (trace.size() % 4 != 0) archive.fail("meter/trace", "does not hold four numbers per point");
  trace_.clear();
  for (std::size_t i = 0; i < trace.size(); i += 4) {
    if (!(trace[i] >= 0.0 && trace[i] <= static_cast<double>(kMostCounted))) {
      archive.fail("meter/trace", "holds what is no count");
    }
    trace_.push_back({static_cast<std::int64_t>(trace[i]), trace[i + 1], trace[i + 2], trace[i + 3] != 0.0});
  }
  std::optional<std::string> failure;  // counted when it was evaluated first
  nearest_.reset();
  if (archive.has("meter/nearest/lengths")) {
    const std::vector<Design> nearest = restored_designs(archive, "meter/nearest", problem.library());
    if (nearest.size() != 1) archive.fail("meter/nearest", "does not hold one design");
    nearest_ = Incumbent{nearest.front(), evaluated(problem, nearest.front(), Fidelity::kFull, {}, failure)};
  }
  best_.reset();
  if (!archive.has("meter/best/lengths")) return;
  const std::vector<Design> best = restored_designs(archive, "meter/best", problem.library());
  if (best.size() != 1) archive.fail("meter/best", "does not hold one design");
  // Achieved with postures that it was given, perhaps: they are kept with it.
  Witness witness;
  if (archive.has("meter/best/postures/rows")) witness.postures = restored_matrix(archive, "meter/best/postures");
  best_ = Incumbent{best.front(), evaluated(problem, best.front(), Fidelity::kFull, witness, failure)};
}

bool Meter::cut_off() const {
  return stop_.stop_requested() || (std::isfinite(budget_.seconds) && elapsed() >= budget_.seconds);
}

double Meter::elapsed() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

}  // namespace modsearch
