#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <modsearch/problem/design_problem.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace modsearch {

class Archive;

/// When a search ends, whichever comes first.
struct Budget {
  /// The target score that every achieved design meets: the search ends at the first one.
  static constexpr double kFirstAchieved = -std::numeric_limits<double>::infinity();

  std::int64_t evaluations = 1'000'000;  ///< calls of the score
  double seconds = std::numeric_limits<double>::infinity();
  /// Ends as soon as an achieved design scores at least this.
  double target_score = std::numeric_limits<double>::infinity();
};

/// Why a search ended.
enum class StopReason {
  kEvaluations,  ///< the budget of evaluations is spent
  kSeconds,      ///< the time is up
  kTargetScore,  ///< the target score is met
  kInterrupted,  ///< somebody asked to stop
  kOptimal,      ///< nothing better is left, by the problem's own bounds
  kUnreachable,  ///< proved: no design of the space is achieved
  kExhausted,    ///< the solver has tried what it would try
};
/// "evaluations", "seconds", "target score", "interrupted", "optimal", "unreachable", "exhausted".
[[nodiscard]] std::string_view name(StopReason reason);

/// What has been spent so far.
struct Progress {
  std::int64_t evaluations = 0;          ///< of the score
  std::int64_t failed = 0;               ///< of these, how many gave NaN or threw
  std::int64_t inconclusive = 0;         ///< of these, how many were not achieved and nothing is proved by it (Attempt)
  std::int64_t program_evaluations = 0;  ///< of smooth programs, with derivatives: inner work
  /// Evaluations by what became of them: [Failure], achieved ones at Failure::kNone; they add up to `evaluations`.
  std::array<std::int64_t, kFailures> outcomes{};
  Work work;             ///< inner work behind the evaluations
  double seconds = 0.0;  ///< wall clock
};

/// A design with what it is worth.
struct Incumbent {
  Design design;
  Evaluation evaluation;
};

/// One improvement of the best design.
struct TracePoint {
  std::int64_t evaluations = 0;
  double seconds = 0.0;
  double score = 0.0;
  bool achieved = false;
};

/// Counts what a solver does, keeps its best, and says when it is time to stop. Solvers evaluate through a meter and
/// never count for themselves, so that every solver is charged alike (the idea is COCO's: the problem counts).
/// For one thread.
class Meter {
 public:
  /// Called after every evaluation and, in long inner loops, every 4096 program evaluations: for progress bars.
  using Observer = std::function<void(const Meter&)>;

  /// The clock starts here. `stop`: where somebody may ask to stop (Ctrl-C).
  /// Throws std::invalid_argument for a budget that is negative or NaN.
  explicit Meter(Budget budget = {}, Observer observer = {}, std::stop_token stop = {});

  /// The score of `design`, or nothing when it is time to stop: then nothing was evaluated, or an evaluation was cut off
  /// in its middle, which is not counted and says nothing. A score of NaN counts as
  /// -inf, not achieved, Failure::kNotANumber; so does an evaluation that throws EvaluationError, with Failure::kThrew:
  /// one bad design of a user's task does not end a search. Misuse (std::invalid_argument) passes through, counted.
  /// A screening is counted but never becomes the best: it promises a score and does not show it.
  [[nodiscard]] std::optional<Evaluation> evaluate(const DesignProblem& problem, const Design& design,
                                                   Fidelity fidelity = Fidelity::kFull, const Witness& witness = {});

  /// Counts inner work that was not part of an evaluation.
  void count(const Work& work) { progress_.work += work; }
  /// What the solver is at, in a few words for whoever watches: "poses: 1200 sequences, 31 meet them". Calls the
  /// observer.
  void say(std::string stage);
  [[nodiscard]] const std::string& stage() const { return stage_; }
  /// Counts evaluations of a smooth program.
  void count_program(std::int64_t evaluations);

  /// Whether it is time to stop, and why. Cheap: inner loops poll it.
  [[nodiscard]] std::optional<StopReason> stopped() const;
  [[nodiscard]] Progress progress() const;
  [[nodiscard]] const Budget& budget() const { return budget_; }
  /// The best design so far in full fidelity (standing, then score; the first of equals); empty before the first.
  [[nodiscard]] const std::optional<Incumbent>& best() const { return best_; }
  /// While nothing is achieved: the design that came nearest, which the best by its score seldom is (often that is the
  /// empty one, for it weighs nothing). The least relative error (Attempt) counts; among designs that reach, the one
  /// that failed the latest test in the order of Failure, then the larger clearance or the smaller share of a torque.
  /// Designs without an end effector come last. Its evaluation may be a screening: what fails at a low fidelity fails
  /// at the full one too. Empty before the first evaluation, and as soon as a design is achieved.
  [[nodiscard]] const std::optional<Incumbent>& nearest() const { return nearest_; }
  /// Every improvement of the best, in order.
  [[nodiscard]] const std::vector<TracePoint>& trace() const { return trace_; }
  /// What the first evaluation that failed had to say; empty: none has.
  [[nodiscard]] const std::string& first_failure() const { return first_failure_; }

  /// Everything but budget, observer and stop token, for checkpoints; the clock goes on where it was.
  void save(Archive& archive) const;
  /// `problem`: the best design is evaluated again (not counted). Throws FileError if the archive holds no meter.
  void restore(const Archive& archive, const DesignProblem& problem);

 private:
  [[nodiscard]] double elapsed() const;
  // Somebody asks to stop, or the time is up: also in the middle of an evaluation.
  [[nodiscard]] bool cut_off() const;
  void remember_nearest(const Design& design, const Evaluation& evaluation);

  Budget budget_;
  Observer observer_;
  std::stop_token stop_;
  std::chrono::steady_clock::time_point start_;
  Progress progress_;
  std::optional<Incumbent> best_;
  std::optional<Incumbent> nearest_;
  std::vector<TracePoint> trace_;
  std::string first_failure_;
  std::string stage_;
};

}  // namespace modsearch
