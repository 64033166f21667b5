#include <fmt/format.h>

#include <cmath>
#include <modsearch/baselines/auto_solver.hpp>
#include <modsearch/baselines/branch_and_bound.hpp>
#include <modsearch/baselines/eliminate.hpp>
#include <modsearch/baselines/genetic_algorithm.hpp>
#include <modsearch/baselines/lexicographic.hpp>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/baselines/pose_first.hpp>
#include <modsearch/problem/sequence_count.hpp>
#include <utility>

namespace modsearch {
namespace {

// Some sequence of one module has a smooth program.
bool has_smooth_programs(const DesignProblem& problem) {
  for (const int k : problem.successors({})) {
    const int types[] = {k};
    try {
      if (problem.relax(types)) return true;
    } catch (const std::exception&) {
      // One that fails may have sound neighbours.
    }
  }
  return false;
}

// Arms have to bring their tip into orientations, not to positions alone: one of few joints does so by luck.
bool asks_for_poses(const DesignProblem& problem) {
  const std::vector<int> first = problem.successors({});
  if (first.empty()) return false;
  const std::unique_ptr<PoseProgram> program = problem.pose_program(std::span{first}.first(1));
  return program && program->asks_for_orientation();
}

double n_sequences(const DesignProblem& problem) {
  double sum = 0.0;
  for (int n = 1; n < problem.max_modules(); ++n) sum += count_sequences(problem.library(), n).complete;
  return sum;
}

// Some thousand sequences take a second, so that these fit into the half minute that `modsearch solve` takes at most.
constexpr double kMany = 100'000.0;
// Fewer are gone through one by one as long as that finds something.
constexpr double kSome = 1'000.0;
// Of too many sequences, the first are worth a look: steps of the search through them, a second or so.
constexpr std::int64_t kFirstSteps = 2'000;
// Where these show nothing, fewer: arms of many modules are dear, and sequences that reach come late. What is left of
// the budget is no reason, for a search that is resumed with another one has to go the same way.
constexpr std::int64_t kFirstStepsInVain = 60;
// What a proof may take where it has not been asked for: half a second or so. One module takes 30 boxes, two among
// obstacles a few thousand.
constexpr std::int64_t kProofBoxes = 2'000;

class AutoSearch final : public Search {
 public:
  AutoSearch(const DesignProblem& problem, Rng rng) : problem_{problem}, rng_{rng} {
    n_sequences_ = n_sequences(problem);
    const bool discrete = problem.library().max_parameters() == 0;
    if (n_sequences_ > kSome && asks_for_poses(problem)) {
      enter(Phase::kPoses);
      return;
    }
    if (discrete) {
      first_ = std::make_unique<Eliminate>();
    } else if (has_smooth_programs(problem)) {
      first_ = std::make_unique<PerSequence>();
    }
    enter(first_ ? Phase::kSequences : afterwards());
  }

  std::optional<SearchEnd> step(Meter& meter) override {
    std::optional<SearchEnd> end = search_->step(meter);
    ++steps_;
    if (end && phase_ == Phase::kSequences && !meter.stopped()) {
      // Starts that failed are no proof, so that there is more to try where nothing is achieved.
      const bool in_vain = end->stop == StopReason::kExhausted && !any_achieved(meter);
      if (in_vain || provable(*end)) {
        found_ = std::move(end->reason);
        enter(in_vain ? afterwards() : Phase::kProof);
        return std::nullopt;
      }
    }
    if (end) return told(std::move(*end), meter);
    if (phase_ == Phase::kSequences && too_long(meter)) enter(afterwards());
    return std::nullopt;
  }

  void save(Archive& archive) const override {
    archive.put_integer("auto/phase", static_cast<std::int64_t>(phase_));
    archive.put_integer("auto/steps", steps_);
    archive.put_text("auto/found", found_);
    search_->save(archive);
  }
  void restore(const Archive& archive) override {
    const std::int64_t phase = archive.integer("auto/phase");
    for (const Phase known : {Phase::kSequences, Phase::kEvolution, Phase::kProof, Phase::kPoses}) {
      if (phase == static_cast<std::int64_t>(known) && known != phase_) enter(known);
    }
    steps_ = archive.integer("auto/steps");
    found_ = archive.text("auto/found");
    search_->restore(archive);
  }

 private:
  enum class Phase { kSequences, kEvolution, kProof, kPoses };  // the numbers stand in checkpoints

  [[nodiscard]] const SteppedSolver& method() const {
    switch (phase_) {
      case Phase::kSequences:
        return *first_;
      case Phase::kEvolution:
        return evolution_;
      case Phase::kProof:
        return proof_;
      case Phase::kPoses:
        return poses_;
    }
    return evolution_;
  }

  void enter(Phase phase) {
    phase_ = phase;
    search_ = method().start(problem_, rng_);
  }

  // What goes on where single sequences, one after the other, lead nowhere.
  [[nodiscard]] Phase afterwards() const { return PoseFirst::covers(problem_) ? Phase::kPoses : Phase::kEvolution; }

  [[nodiscard]] static bool any_achieved(const Meter& meter) {
    return meter.best() && meter.best()->evaluation.attempt.achieved;
  }

  // Going through the sequences takes too long: there are too many, or the first have shown nothing.
  [[nodiscard]] bool too_long(const Meter& meter) const {
    const bool in_vain = !any_achieved(meter);
    return steps_ >= (in_vain ? kFirstStepsInVain : kFirstSteps) && n_sequences_ > (in_vain ? kSome : kMany);
  }

  // Lengths were optimised, or searches for postures gave up, and nothing is proved yet.
  [[nodiscard]] bool provable(const SearchEnd& end) const {
    return end.stop == StopReason::kExhausted && proof_.covers(problem_);
  }

  // The end of the method in one line: what was done, how it ended, what is proved.
  [[nodiscard]] SearchEnd told(SearchEnd end, const Meter& meter) const {
    std::string did;
    if (phase_ == Phase::kSequences) {
      did = first_->name();
    } else if (phase_ == Phase::kProof) {
      did = fmt::format("{}: {}; then {}", first_->name(), found_, proof_.name());
    } else if (first_) {
      const std::string in_vain = found_.empty() ? "" : fmt::format(" ({})", found_);
      did =
          fmt::format("{} of {:.4g} type sequences{}, then {}", first_->name(), n_sequences_, in_vain, method().name());
    } else if (phase_ == Phase::kPoses) {
      did = fmt::format("{}, for the goals ask for orientations and there are {:.4g} type sequences", poses_.name(),
                        n_sequences_);
    } else {
      did = evolution_.name();
    }
    if (!end.reason.empty()) did += ": " + end.reason;
    const double best = score_to_beat(meter);
    if (end.stop == StopReason::kOptimal) {
      const double gap = end.bound ? end.bound->score - best : 0.0;
      did += gap > 0.0 ? fmt::format("; proved optimal to within {} points", rounded_up(gap, 2)) : "; proved optimal";
    } else if (end.stop == StopReason::kUnreachable) {
      did += "; proved unreachable";
    } else if (end.bound && std::isfinite(end.bound->score) && std::isfinite(best)) {
      did += fmt::format("; proved: none scores above {}", rounded_up(end.bound->score));
    }
    end.reason = std::move(did);
    return end;
  }

  const DesignProblem& problem_;
  Rng rng_;
  std::unique_ptr<SteppedSolver> first_;  // null: nothing can be done with single sequences
  GeneticAlgorithm evolution_;
  PoseFirst poses_;
  BranchAndBound proof_{{.boxes = kProofBoxes}};
  double n_sequences_ = 0.0;
  Phase phase_ = Phase::kSequences;
  std::int64_t steps_ = 0;
  std::string found_;  // what was said of the sequences, once they are being proved
  std::unique_ptr<Search> search_;
};

}  // namespace

std::unique_ptr<Search> AutoSolver::start(const DesignProblem& problem, Rng rng) const {
  return std::make_unique<AutoSearch>(problem, rng);
}

}  // namespace modsearch
