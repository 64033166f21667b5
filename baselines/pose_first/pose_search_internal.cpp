#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <modsearch/baselines/lexicographic.hpp>
#include <modsearch/baselines/pose_first/pose_search_internal.hpp>
#include <modsearch/baselines/pose_first/sequence_change_internal.hpp>
#include <modsearch/kinematics/interruption.hpp>
#include <modsearch/solvers/inner_solver.hpp>

namespace modsearch::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Work in steps of the pose program, half a microsecond or so each, by what was counted: nothing here looks at a clock.
constexpr double kStepsPerEvaluation = 60.0;
constexpr double kStepsPerProgram = 60.0;
constexpr double kStepsPerState = 4.0;
constexpr double kStepsPerSequence = 150.0;
// How fast patience with the planner grows while no path was found: tenfold in thirteen plans.
constexpr double kLessHasty = 1.2;

// The postures at `v`, and no others: there are other points to try.
Witness only(const PoseProgram& program, const Eigen::VectorXd& v) {
  Witness witness = program.witness(v);
  witness.only = true;
  return witness;
}

double work_of(const Progress& before, const Progress& after) {
  return kStepsPerEvaluation * static_cast<double>(after.evaluations - before.evaluations) +
         kStepsPerProgram * static_cast<double>(after.program_evaluations - before.program_evaluations) +
         kStepsPerState * static_cast<double>(after.work.planner_states - before.work.planner_states);
}

}  // namespace

PoseSearch::PoseSearch(const PoseFirstOptions& options, const DesignProblem& problem, Rng rng)
    : options_{options},
      problem_{problem},
      rng_{rng},
      belief_{problem, rng.fork("belief")},
      covered_{PoseFirst::covers(problem)} {}

std::optional<SearchEnd> PoseSearch::step(Meter& meter) {
  // Of arms of dozens of joints among meshes one try takes seconds, between which the meter is heard.
  const auto cut_off = [&] {
    const std::optional<StopReason> why = meter.stopped();
    return why == StopReason::kSeconds || why == StopReason::kInterrupted;
  };
  try {
    const Interruptible scope{cut_off};
    return go_on(meter);
  } catch (const Interrupted&) {
    return SearchEnd{};
  }
}

std::optional<SearchEnd> PoseSearch::go_on(Meter& meter) {
  if (!begun_) {
    const std::optional<Evaluation> empty = meter.evaluate(problem_, Design{});
    if (!empty) return SearchEnd{};
    floor_ = std::isfinite(empty->score) ? empty->score : 0.0;
    begun_ = true;
  }
  if (!covered_) return SearchEnd{StopReason::kExhausted, "the problem has no poses that could be solved for", {}};
  if (std::optional<SearchEnd> end = pointless(meter, problem_)) return end;
  // Half of the work goes into what is new, half into what was found, once there is something.
  const bool tried = !elites_.empty() && improved_ < explored_ ? improve(meter) : explore(meter);
  if (meter.stopped()) return SearchEnd{};
  idle_ = tried ? 0 : idle_ + 1;
  constexpr int kPatience = 1000;
  if (idle_ < kPatience) return std::nullopt;
  return SearchEnd{StopReason::kExhausted, "no type sequence was met that could beat the best by its bound", {}};
}

double PoseSearch::to_beat(const Meter& meter) const {
  const double best = score_to_beat(meter);
  return best > -kInfinity ? best : std::min(floor_, belief_.greatest_bound() - 1.0);
}

bool PoseSearch::explore(Meter& meter) {
  std::optional<SequenceBelief::Drawn> drawn = belief_.draw(to_beat(meter), rng_);
  if (!drawn) return false;
  const Try what{.types = std::move(drawn->types),
                 .bound = drawn->bound,
                 .n_starts = options_.starts,
                 .start = [&](int, Eigen::Ref<Eigen::VectorXd> v, const PoseProgram& program) {
                   for (Eigen::Index i = 0; i < v.size(); ++i) {
                     v[i] = rng_.uniform(program.lower()[i], program.upper()[i]);
                   }
                 }};
  const Outcome outcome = attempt(what, meter);
  belief_.learn(what.types, outcome.success, outcome.work);
  explored_ += outcome.work;
  return true;
}

bool PoseSearch::improve(Meter& meter) {
  // The better ones more often: the least of two random ranks.
  const int n = static_cast<int>(elites_.size());
  const int pick = std::min(rng_.index(n), rng_.index(n));
  const Elite& elite = elites_[static_cast<std::size_t>(pick)];
  std::optional<SequenceChange> change = changed(problem_, elite.types, rng_);
  if (!change) return false;
  const double bound = problem_.optimism(change->types).score;
  improved_ += kStepsPerSequence;
  if (!(bound > to_beat(meter))) return true;
  Try what{.types = change->types, .bound = bound, .n_starts = 2 * options_.starts, .start = {}};
  const Eigen::VectorXd from = elite.v;
  what.start = [&](int i, Eigen::Ref<Eigen::VectorXd> v, const PoseProgram& p) {
    carry_over(*change, from, i, p.lower(), p.upper(), rng_, v);
  };
  improved_ += attempt(what, meter).work;
  return true;
}

PoseSearch::Outcome PoseSearch::attempt(const Try& what, Meter& meter) {
  constexpr double kMetAlone = 0.25;  // of a success: the poses are met, and all that was found overlaps
  ++tried_;
  no_path_ = 0;
  Outcome outcome{.work = kStepsPerSequence};
  const Progress before = meter.progress();
  const std::int64_t free_before = free_;
  try {
    const std::unique_ptr<PoseProgram> program = problem_.pose_program(what.types);
    if (!program || !program->generic()) return outcome;
    std::vector<Arrival> here = arrivals(what, *program, meter, outcome.work);
    if (here.empty()) return outcome;
    ++met_;
    settle(what, *program, std::move(here), meter);
  } catch (const std::exception&) {
    return outcome;  // a user's program that throws ends this try, not the search
  }
  outcome.work += work_of(before, meter.progress());
  outcome.success = free_ > free_before ? 1.0 : kMetAlone;
  return outcome;
}

std::vector<PoseSearch::Arrival> PoseSearch::arrivals(const Try& what, PoseProgram& program, Meter& meter,
                                                      double& work) {
  constexpr std::size_t kEnough = 6;
  std::vector<Arrival> here;
  tell("poses", meter);
  const PoseProgram::Outcome outcome = program.solve(
      what.n_starts, [&](int i, Eigen::Ref<Eigen::VectorXd> v) { what.start(i, v, program); },
      [&](int, const Eigen::VectorXd& v) {
        const std::optional<Evaluation> screen =
            meter.evaluate(problem_, program.design(v), Fidelity::kScreen, only(program, v));
        if (!screen) return false;
        here.push_back({v, *screen});
        return here.size() < kEnough;
      });
  work += static_cast<double>(outcome.steps);
  meter.count(Work{.ik_iterations = outcome.steps});
  return here;
}

// Those that are free first, by score; then by how little they overlap.
void PoseSearch::settle(const Try& what, const PoseProgram& program, std::vector<Arrival> here, Meter& meter) {
  std::stable_sort(here.begin(), here.end(), [](const Arrival& a, const Arrival& b) {
    const Attempt& x = a.screen.attempt;
    const Attempt& y = b.screen.attempt;
    if (x.achieved != y.achieved) return x.achieved;
    return x.achieved ? a.screen.score > b.screen.score : x.clearance > y.clearance;
  });
  constexpr std::size_t kMostSettled = 3;
  for (std::size_t i = 0; i < std::min(here.size(), kMostSettled) && !meter.stopped(); ++i) {
    settle(what, program, here[i], meter);
  }
}

void PoseSearch::settle(const Try& what, const PoseProgram& program, const Arrival& arrival, Meter& meter) {
  // Margins of the smooth program: a posture that overlaps needs more room than rounding asks for.
  constexpr double kRoom = 4e-3;  // [m]
  constexpr double kLess = 1e-3;
  // What the sequence could gain at most is seldom gained: worth the work where a part of it would do.
  constexpr double kHope = 0.6;
  if (!arrival.screen.attempt.achieved) {
    refine(what, program, arrival.v, kRoom, meter);
    return;
  }
  ++free_;
  const double score = arrival.screen.score;
  keep(what.types, arrival.v, score);
  finish(what, program, arrival.v, arrival.screen, meter);
  if (score + kHope * (what.bound - score) > to_beat(meter)) refine(what, program, arrival.v, kLess, meter);
}

// The evaluation with a path, where the screen promises more than the best.
void PoseSearch::finish(const Try& what, const PoseProgram& program, const Eigen::VectorXd& v, const Evaluation& screen,
                        Meter& meter) {
  constexpr int kMostPlanned = 2;
  if (!(screen.score > to_beat(meter)) || no_path_ >= kMostPlanned) return;
  ++planned_;
  tell("path", meter);
  Witness witness = only(program, v);
  witness.patience = patience_;
  const std::optional<Evaluation> full = meter.evaluate(problem_, program.design(v), Fidelity::kFull, witness);
  if (!full) return;
  if (!full->attempt.achieved) {
    ++no_path_;
    // Most motions are found soon or not at all; where none was found yet, perhaps all are hard to find.
    if (achieved_ == 0) patience_ = std::min(1.0, kLessHasty * patience_);
    return;
  }
  ++achieved_;
  keep(what.types, v, full->score);
}

// Makes room for the bodies and takes off mass, from `v`, by the smooth program.
void PoseSearch::refine(const Try& what, const PoseProgram& program, const Eigen::VectorXd& v, double clearance,
                        Meter& meter) {
  constexpr double kFeasible = 1e-5;  // [m or rad]; the evaluation has the last word
  const std::unique_ptr<SmoothProgram> smooth = problem_.relax(what.types, {.clearance_margin = clearance});
  if (!smooth || smooth->n_variables() != v.size()) return;
  ++refined_;
  tell("clearance and mass", meter);
  const Eigen::VectorXd start = v.cwiseMax(smooth->lower()).cwiseMin(smooth->upper());
  const InnerResult result =
      minimise(Inner::kOwn, *smooth, start, {.max_iterations = options_.iterations, .first_penalty = 1e3}, meter);
  if (result.v.size() != v.size() || !result.v.allFinite() || !(result.violation < kFeasible)) return;
  const std::optional<Evaluation> screen =
      meter.evaluate(problem_, program.design(result.v), Fidelity::kScreen, only(program, result.v));
  if (!screen || !screen->attempt.achieved) return;
  ++free_;
  keep(what.types, result.v, screen->score);
  finish(what, program, result.v, *screen, meter);
}

void PoseSearch::keep(const std::vector<int>& types, const Eigen::VectorXd& v, double score) {
  constexpr std::size_t kMostElites = 16;
  // One of each sequence: its best.
  const auto same = std::find_if(elites_.begin(), elites_.end(), [&](const Elite& e) { return e.types == types; });
  if (same != elites_.end()) {
    if (same->score >= score) return;
    elites_.erase(same);
  }
  const auto at = std::find_if(elites_.begin(), elites_.end(), [&](const Elite& e) { return e.score < score; });
  elites_.insert(at, {types, v, score});
  if (elites_.size() > kMostElites) elites_.pop_back();
}

void PoseSearch::tell(std::string_view stage, Meter& meter) const {
  meter.say(fmt::format("{}: {} sequences, {} meet the poses; {} postures free; {} paths planned, {} found", stage,
                        tried_, met_, free_, planned_, achieved_));
}

void PoseSearch::save(Archive& archive) const {
  put(archive, "rng", rng_);
  belief_.save(archive);
  archive.put("pose-first/counts",
              std::array<std::int64_t, 8>{begun_ ? 1 : 0, idle_, tried_, met_, free_, refined_, planned_, achieved_});
  archive.put("pose-first/numbers", std::array<double, 4>{floor_, explored_, improved_, patience_});
  archive.put_integer("pose-first/elites", static_cast<std::int64_t>(elites_.size()));
  for (std::size_t i = 0; i < elites_.size(); ++i) {
    const std::string name = fmt::format("pose-first/elite {}", i);
    const std::vector<std::int64_t> types(elites_[i].types.begin(), elites_[i].types.end());
    archive.put(name + "/types", std::span<const std::int64_t>{types});
    put(archive, name + "/v", Eigen::MatrixXd{elites_[i].v});
    archive.put_number(name + "/score", elites_[i].score);
  }
}

void PoseSearch::restore(const Archive& archive) {
  rng_ = restored_rng(archive, "rng");
  belief_.restore(archive);
  const std::vector<std::int64_t> counts = archive.integers("pose-first/counts");
  if (counts.size() != 8) archive.fail("pose-first/counts", "does not hold 8 numbers");
  begun_ = counts[0] != 0;
  idle_ = static_cast<int>(counts[1]);
  tried_ = counts[2];
  met_ = counts[3];
  free_ = counts[4];
  refined_ = counts[5];
  planned_ = counts[6];
  achieved_ = counts[7];
  const std::vector<double> numbers = archive.numbers("pose-first/numbers");
  if (numbers.size() != 4) archive.fail("pose-first/numbers", "does not hold 4 numbers");
  floor_ = numbers[0];
  explored_ = numbers[1];
  improved_ = numbers[2];
  patience_ = numbers[3];
  elites_.clear();
  const std::int64_t n = archive.integer("pose-first/elites");
  for (std::int64_t i = 0; i < n; ++i) {
    const std::string name = fmt::format("pose-first/elite {}", i);
    Elite elite;
    for (const std::int64_t k : archive.integers(name + "/types")) elite.types.push_back(static_cast<int>(k));
    elite.v = restored_matrix(archive, name + "/v");
    elite.score = archive.number(name + "/score");
    elites_.push_back(std::move(elite));
  }
}

}  // namespace modsearch::detail
