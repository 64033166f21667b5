#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/baselines/certify/bound_search_internal.hpp>
#include <modsearch/baselines/lexicographic.hpp>
#include <modsearch/baselines/staged.hpp>

namespace modsearch::certify {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// The checker rounds outwards, the search does not: boxes are closed a little above what is claimed.
constexpr double kRounding = 2e-7;
// Share of the gap that boxes are cut to. Where arms of equal mass are many, as long as two links in a row trade their
// lengths, thousands of boxes end just below the cut and would have to be cut until obstacles tell them apart; with
// some room between the cut and the gap, none of them matters.
constexpr double kAim = 0.98;
// Boxes per step, a millisecond or so.
constexpr int kBoxesPerStep = 16;

std::string percent(double share) { return fmt::format("{:.3g} %", 100.0 * share); }

}  // namespace

BoundSearch::BoundSearch(const RobotProblem& problem, const BoundSearchOptions& options)
    : problem_{problem},
      options_{options},
      weight_{problem.spec().scoring->mass_weight()},
      scenery_{scenery_of(problem)},
      frontier_{problem},
      stuck_{-kInfinity} {}

double BoundSearch::score_at(double share) const {
  if (!witness_) return options_.floor;
  return std::max(options_.floor, witness_->score + share * options_.gap * unit_of_gap(problem_, *witness_));
}

double BoundSearch::cut(const Sequence& sequence) const {
  const double score = score_at(kAim);
  if (weight_ <= 0.0) return sequence.head <= score ? -kInfinity : kInfinity;
  const double mass = (sequence.head - score) / weight_;
  return mass + kRounding * std::abs(mass);
}

double BoundSearch::score_bound(const Sequence& sequence) const {
  if (!sequence.tree || sequence.tree->exhausted()) return -kInfinity;
  return weight_ > 0.0 ? sequence.head - weight_ * sequence.tree->least_mass() : sequence.head;
}

double BoundSearch::open_bound() const {
  double bound = std::max(stuck_, frontier_.bound());
  for (const Sequence& sequence : sequences_) bound = std::max(bound, score_bound(sequence));
  return bound;
}

double BoundSearch::upper(const Meter& meter) const {
  if (!begun_) return kInfinity;
  return std::max({open_bound(), closing_score(), score_to_beat(meter)});
}

std::int64_t BoundSearch::expanded() const {
  std::int64_t sum = 0;
  for (const Sequence& sequence : sequences_) {
    const SequenceTree* tree = sequence.tree ? sequence.tree.get() : sequence.given_up.get();
    sum += tree == nullptr ? 0 : tree->expanded();
  }
  return sum;
}

std::int64_t BoundSearch::n_open() const {
  std::int64_t sum = 0;
  for (const Sequence& sequence : sequences_) {
    sum += sequence.tree ? static_cast<std::int64_t>(sequence.tree->n_open()) : 0;
  }
  return sum;
}

SequenceTree* BoundSearch::tree(std::span<const int> types) {
  if (!options_.recorded) return nullptr;
  for (const Sequence& sequence : sequences_) {
    if (!std::equal(types.begin(), types.end(), sequence.types.begin(), sequence.types.end())) continue;
    return sequence.tree ? sequence.tree.get() : sequence.given_up.get();
  }
  return nullptr;
}

std::string BoundSearch::what_is_open() const {
  std::string text;
  const double bound = open_bound();
  for (const Sequence& sequence : sequences_) {
    if (score_bound(sequence) < bound) continue;
    for (const int k : sequence.types) text += problem_.library().type(k).id + " ";
    text += sequence.tree->description();
    break;
  }
  return text;
}

void BoundSearch::consider(const Design& design, const Eigen::MatrixXd& postures) {
  std::optional<Witness> found = witness(problem_, design, postures);
  if (found && (!witness_ || found->score > witness_->score)) witness_ = std::move(found);
}

// One local optimum, as it is found and with more and more room around obstacles until it is achieved for what it is
// worth: the score looks at the posture closest to the goal, the bound at any within the tolerance.
void BoundSearch::look_for_design(Sequence& sequence, const Eigen::VectorXd& start, bool weak, Meter& meter) {
  constexpr double kClearances[] = {1e-6, 1e-3, 4e-3, 1.6e-2};
  const int n_goals = static_cast<int>(scenery_.targets.size());
  Eigen::VectorXd from = start;
  for (const double clearance : kClearances) {
    if (meter.stopped()) return;
    std::unique_ptr<SmoothProgram> roomier;
    if (clearance > kClearances[0]) roomier = problem_.relax(sequence.types, {.clearance_margin = clearance});
    SmoothProgram& program = roomier ? *roomier : *sequence.program;
    const InnerOptions inner{.first_penalty = weak ? 1.0 : 1e3};
    const InnerResult result =
        minimise(Inner::kOwn, program, from.cwiseMax(program.lower()).cwiseMin(program.upper()), inner, meter);
    if (result.v.size() != program.n_variables() || !result.v.allFinite() || result.violation > 1e-6) return;
    const Design design = program.design(result.v);
    const Eigen::Index n_x = design.parameters().size();
    const Eigen::Index n_q = (result.v.size() - n_x) / n_goals;
    Eigen::MatrixXd postures(n_goals, n_q);
    for (int g = 0; g < n_goals; ++g) postures.row(g) = result.v.segment(n_x + g * n_q, n_q).transpose();
    consider(design, postures);
    const double mass = problem_.chain(sequence.types)->mass(design.parameters());
    if (score_of(problem_, sequence.types, mass) <= score_to_beat(meter) + 1e-9) return;
    const std::optional<Evaluation> evaluation = evaluate_staged(meter, problem_, design, {.postures = postures});
    if (!evaluation) return;
    if (evaluation->attempt.achieved) {
      consider(design, evaluation->attempt.postures);
      return;
    }
    if (!evaluation->attempt.reached) return;
    from = result.v;
  }
}

void BoundSearch::add(std::vector<int> types, double bound, Meter& meter) {
  Sequence sequence;
  sequence.types = std::move(types);
  sequence.head = score_of(problem_, sequence.types, 0.0);
  if (!problem_.library().complete(sequence.types)) return;
  sequence.tree = std::make_unique<SequenceTree>(problem_, scenery_, sequence.types, options_.recorded);
  if (!sequence.tree->model().fits()) {
    stuck_ = std::max(stuck_, bound);
    return;
  }
  sequence.tree->open(cut(sequence));
  if (!sequence.tree->exhausted()) {
    sequence.program = problem_.relax(sequence.types);
    for (int i = 0; i < 2 && !sequence.tree->exhausted(); ++i) {
      look_for_design(sequence, i == 0 ? sequence.tree->middle() : sequence.program->start(i), i == 1, meter);
    }
    sequence.next_solve = 1;
  }
  sequences_.push_back(std::move(sequence));
}

std::optional<SearchEnd> BoundSearch::step(Meter& meter) {
  if (!begun_) {
    if (!meter.evaluate(problem_, Design{})) return end(meter);
    const Optimism bare = problem_.optimism({});
    if (bare.score > -kInfinity) add({}, bare.score, meter);
    begun_ = true;
  }
  if (options_.most_boxes > 0 && expanded() >= options_.most_boxes) return end(meter);
  for (int box = 0; box < kBoxesPerStep; ++box) {
    if (meter.stopped()) return end(meter);
    Sequence* best = nullptr;
    for (Sequence& sequence : sequences_) {
      if (best == nullptr || score_bound(sequence) > score_bound(*best)) best = &sequence;
    }
    const double score = best == nullptr ? -kInfinity : score_bound(*best);
    const double closing = closing_score();
    if (std::max(score, frontier_.bound()) <= closing) {
      closed_ = stuck_ <= closing;
      return end(meter);
    }
    if (frontier_.bound() >= score) {
      const std::optional<SequenceFrontier::Sequence> next = frontier_.next(meter);
      if (next && next->bound > closing) {
        add(next->types, next->bound, meter);
        if (meter.stopped()) return end(meter);  // perhaps in the middle of it
        return std::nullopt;
      }
      if (!next && frontier_.exhausted() && score == -kInfinity) {
        closed_ = stuck_ <= closing;
        return end(meter);
      }
      continue;
    }
    if (best->tree->expanded() >= best->next_solve) {
      // A better design lowers the cut everywhere: a local search costs as much as ten boxes or so.
      best->next_solve += std::max<std::int64_t>(8, best->next_solve / 5);
      look_for_design(*best, best->tree->middle(), best->tree->expanded() % 3 == 0, meter);
      if (meter.stopped()) return end(meter);
      return std::nullopt;
    }
    if (!best->tree->expand(cut(*best))) {
      // Perhaps because there is such a design.
      for (const bool weak : {false, true}) {
        look_for_design(*best, best->tree->middle(), weak, meter);
        if (meter.stopped()) return end(meter);
      }
      if (score_bound(*best) <= closing_score()) continue;
      stuck_ = std::max(stuck_, score + 1e-6 * std::max(1.0, std::abs(score)));  // a proof has to get there again
      if (options_.recorded) best->given_up = std::move(best->tree);
      best->tree.reset();
    }
  }
  return std::nullopt;
}

SearchEnd BoundSearch::end(const Meter& meter) const {
  if (!begun_) return {StopReason::kExhausted, "", std::nullopt};
  const double bound = upper(meter);
  const std::int64_t boxes = expanded();
  const std::vector<Tally> tallies{{"boxes", static_cast<double>(boxes)},
                                   {"sequences", static_cast<double>(sequences_.size())}};
  const std::string reason = "certified branch and bound";
  if (!closed_) {
    const bool limited = options_.most_boxes > 0 && boxes >= options_.most_boxes;
    return {StopReason::kExhausted, limited ? fmt::format("{} boxes", boxes) : "", Bound{bound, reason}, tallies};
  }
  if (bound == -kInfinity) {
    const std::string& why = frontier_.impossible();
    return {StopReason::kUnreachable,
            sequences_.empty() && !why.empty()
                ? why
                : fmt::format("no arm of {} type sequences reaches free of obstacles", sequences_.size()),
            Bound{bound, reason}, tallies};
  }
  const double best = score_to_beat(meter);
  const double unit = witness_ ? unit_of_gap(problem_, *witness_) : 1.0;
  const bool optimal = bound - best <= options_.gap * unit + 1e-9 * std::abs(bound);
  std::string what = fmt::format("none scores above {}", rounded_up(bound, 9));
  if (optimal) {
    const bool of_mass = witness_ && weight_ * witness_->mass > 0.0;
    what += fmt::format(", {} of the {} from the best", percent((bound - best) / unit), of_mass ? "mass" : "score");
  } else if (witness_) {
    what += fmt::format(
        "; an arm that scores {:.9g} reaches free of obstacles, though not at its posture closest to the "
        "goals or not at the level asked for",
        witness_->score);
  }
  return {optimal ? StopReason::kOptimal : StopReason::kExhausted, what, Bound{bound, reason}, tallies};
}

void BoundSearch::save(Archive& archive) const {
  frontier_.save(archive);
  std::vector<std::int64_t> numbers;  // per sequence: a tree is open, when to look for a design again, types
  std::vector<std::int64_t> lengths;
  for (std::size_t i = 0; i < sequences_.size(); ++i) {
    const Sequence& sequence = sequences_[i];
    numbers.push_back(sequence.tree ? 1 : 0);
    numbers.push_back(sequence.next_solve);
    numbers.insert(numbers.end(), sequence.types.begin(), sequence.types.end());
    lengths.push_back(static_cast<std::int64_t>(sequence.types.size()));
    if (sequence.tree) sequence.tree->save(archive, fmt::format("tree/{}", i));
  }
  archive.put("bound/lengths", std::span<const std::int64_t>{lengths});
  archive.put("bound/sequences", std::span<const std::int64_t>{numbers});
  archive.put("bound/state", std::array<std::int64_t, 2>{begun_ ? 1 : 0, closed_ ? 1 : 0});
  archive.put_number("bound/stuck", stuck_);
  std::vector<Design> designs;
  std::vector<double> postures;
  if (witness_) {
    designs.push_back(witness_->design);
    postures.assign(witness_->postures.data(), witness_->postures.data() + witness_->postures.size());
  }
  put(archive, "bound/witness", designs);
  archive.put("bound/postures", std::span<const double>{postures});
}

void BoundSearch::restore(const Archive& archive) {
  frontier_.restore(archive);
  const std::vector<std::int64_t> lengths = archive.integers("bound/lengths");
  const std::vector<std::int64_t> numbers = archive.integers("bound/sequences");
  const std::vector<std::int64_t> state = archive.integers("bound/state");
  if (state.size() != 2) archive.fail("bound/state", "does not hold 2 numbers");
  begun_ = state[0] != 0;
  closed_ = state[1] != 0;
  stuck_ = archive.number("bound/stuck");
  sequences_.clear();
  std::size_t at = 0;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    if (lengths[i] < 0 || lengths[i] >= problem_.max_modules() ||
        at + 2 + static_cast<std::size_t>(lengths[i]) > numbers.size()) {
      archive.fail("bound/sequences", "is not a list of type sequences of this problem");
    }
    Sequence sequence;
    const bool open = numbers[at++] != 0;
    sequence.next_solve = numbers[at++];
    for (std::int64_t k = 0; k < lengths[i]; ++k) {
      if (numbers[at] < 0 || numbers[at] >= problem_.library().n_types()) {
        archive.fail("bound/sequences", "is not a list of type sequences of this problem");
      }
      sequence.types.push_back(static_cast<int>(numbers[at++]));
    }
    if (!problem_.library().fits_together(sequence.types)) {
      archive.fail("bound/sequences", "is not a list of type sequences of this problem");
    }
    sequence.head = score_of(problem_, sequence.types, 0.0);
    if (open) {
      sequence.tree = std::make_unique<SequenceTree>(problem_, scenery_, sequence.types);
      sequence.tree->restore(archive, fmt::format("tree/{}", i));
      if (!sequence.tree->exhausted()) sequence.program = problem_.relax(sequence.types);
    }
    sequences_.push_back(std::move(sequence));
  }
  witness_.reset();
  const std::vector<Design> designs = restored_designs(archive, "bound/witness", problem_.library());
  const std::vector<double> postures = archive.numbers("bound/postures");
  if (designs.empty()) return;
  const int n_joints = problem_.chain(designs[0].types())->n_joints();
  const auto n_goals = static_cast<Eigen::Index>(scenery_.targets.size());
  if (postures.size() != static_cast<std::size_t>(n_goals * n_joints)) {
    archive.fail("bound/postures", "are not those of the witness");
  }
  consider(designs[0], Eigen::Map<const Eigen::MatrixXd>(postures.data(), n_goals, n_joints));
}

}  // namespace modsearch::certify
