#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/baselines/lexicographic.hpp>
#include <modsearch/baselines/staged.hpp>

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Rank::Level level(const Attempt& attempt) {
  using Level = Rank::Level;
  if (attempt.achieved) return Level::kAchieved;
  switch (attempt.why) {
    case Failure::kNotANumber:
    case Failure::kThrew:
      return Level::kFailed;
    case Failure::kIncomplete:
      return Level::kIncomplete;
    case Failure::kNone:
    case Failure::kProvedInfeasible:
    case Failure::kUnreachable:
    case Failure::kLimit:
    case Failure::kJump:
      return Level::kMisses;
    case Failure::kTorque:
    case Failure::kObstacle:
    case Failure::kSelfCollision:
      return Level::kCollides;
    case Failure::kHomeInCollision:
    case Failure::kNoPath:
      return Level::kNoPath;
  }
  return Level::kMisses;
}

}  // namespace

Rank rank(const Evaluation& evaluation) {
  const Attempt& attempt = evaluation.attempt;
  Rank result{level(attempt), 0.0, evaluation.score};
  if (result.level == Rank::Level::kMisses) result.within = -attempt.relative_error;
  if (result.level == Rank::Level::kCollides) result.within = std::min(attempt.clearance, 0.0);
  if (attempt.why == Failure::kTorque) result.within = std::min(result.within, 1.0 - attempt.torque_share);
  // A user's task may leave anything in there, and NaN has no order.
  if (std::isnan(result.within)) result.within = -kInfinity;
  return result;
}

std::optional<Rank> evaluate_rank(Meter& meter, const DesignProblem& problem, const Design& design) {
  if (meter.stopped()) return std::nullopt;
  if (problem.optimism(design.types()).score <= score_to_beat(meter)) return Rank{};
  const std::optional<Evaluation> evaluation = evaluate_staged(meter, problem, design);
  if (!evaluation) return std::nullopt;
  return rank(*evaluation);
}

double score_to_beat(const Meter& meter) {
  return meter.best() && meter.best()->evaluation.attempt.achieved ? meter.best()->evaluation.score : -kInfinity;
}

std::string rounded_up(double bound, int digits) {
  if (!std::isfinite(bound) || bound == 0.0) return fmt::format("{}", bound);
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(bound))) + 1 - digits);
  return fmt::format("{:.{}g}", std::ceil(bound / unit) * unit, digits);
}

bool is_settled(const Evaluation& evaluation) {
  return evaluation.attempt.achieved || !evaluation.attempt.inconclusive;
}

std::string nothing_proved(const Meter& meter) {
  return fmt::format("the search for postures or a motion gave up in {} of {} evaluations, which proves nothing",
                     meter.progress().inconclusive, meter.progress().evaluations);
}

std::optional<SearchEnd> pointless(const Meter& meter, const DesignProblem& problem) {
  if (problem.successors({}).empty()) return SearchEnd{StopReason::kExhausted, "no module may be attached", {}};
  Optimism best{-kInfinity, ""};
  for (int n = 1; n < problem.max_modules(); ++n) {
    Optimism optimism = problem.optimism_of_length(n);
    if (optimism.score >= best.score) best = std::move(optimism);
  }
  const double to_beat = score_to_beat(meter);
  if (best.score > to_beat) return std::nullopt;
  if (to_beat == -kInfinity) {
    return SearchEnd{StopReason::kUnreachable, std::move(best.reason), Bound{-kInfinity, "reach"}};
  }
  return SearchEnd{StopReason::kOptimal, "no design can score more by its number of modules and its mass",
                   Bound{to_beat, "number of modules and least mass by reach"}};
}

Rank restored_rank(const Archive& archive, const std::string& entry, std::int64_t level, double within, double score) {
  constexpr auto kLast = static_cast<std::int64_t>(Rank::Level::kAchieved);
  if (level < 0 || level > kLast) archive.fail(entry, fmt::format("holds level {} (limit: [0, {}])", level, kLast));
  if (std::isnan(within) || std::isnan(score)) archive.fail(entry, "has a rank that is not a number");
  return {static_cast<Rank::Level>(level), within, score};
}

}  // namespace modsearch
