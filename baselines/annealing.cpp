#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/baselines/annealing.hpp>
#include <modsearch/baselines/design_moves_internal.hpp>
#include <modsearch/baselines/lexicographic.hpp>
#include <modsearch/baselines/random_search.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Walk final : public Search {
 public:
  Walk(const AnnealingOptions& options, const DesignProblem& problem, Rng rng)
      : options_{options}, problem_{problem}, rng_{rng} {}

  // Some proposals.
  std::optional<SearchEnd> step(Meter& meter) override {
    if (!begun_ && !meter.evaluate(problem_, Design{})) return SearchEnd{};
    begun_ = true;
    if (std::optional<SearchEnd> end = pointless(meter, problem_)) return end;
    constexpr int kBatch = 50;  // proposals between two places where the search can be taken up: arbitrary
    for (int i = 0; i < kBatch; ++i) {
      if (!propose(meter)) return SearchEnd{};
    }
    constexpr int kPatience = 10'000;  // proposals; arbitrary
    if (idle_ < kPatience) return std::nullopt;
    return SearchEnd{StopReason::kExhausted,
                     fmt::format("{} proposals in a row could not beat the best by their bounds", kPatience),
                     {}};
  }

  void save(Archive& archive) const override;
  void restore(const Archive& archive) override;

 private:
  // One proposal, taken or not. False: time to stop.
  bool propose(Meter& meter) {
    if (taken_ == options_.cycle) heat();
    // Where the walk stands may have lost its point, because something else has become the best.
    if (here_.modules.empty() || bound_of(here_) <= score_to_beat(meter)) {
      here_ = score_to_beat(meter) > -kInfinity && rng_.uniform() < 0.5 ? meter.best()->design
                                                                        : random_design(problem_, rng_);
      mend(problem_, here_, rng_);
      rank_ = Rank{};
    }
    const bool restructured = rng_.uniform() < options_.structure || n_parameters(here_) == 0;
    Design there = restructured ? changed_sequence(problem_, here_, rng_) : moved(here_);
    const std::optional<Rank> rank = evaluate_rank(meter, problem_, there);
    if (!rank) return false;
    ++idle_;
    if (rank->level == Rank::Level::kHopeless) return true;
    idle_ = 0;
    const double temperature =
        options_.hot * std::pow(options_.cold / options_.hot, static_cast<double>(taken_) / options_.cycle);
    ++taken_;
    const double loss = worth(here_, rank_) - worth(there, *rank);
    const bool accepted = !(loss > 0.0) || rng_.uniform() < std::exp(-loss / temperature);
    // Two in five: with these factors the logarithm of the step stands still on average.
    if (!restructured) step_ = std::clamp(step_ * (accepted ? 1.2 : std::pow(1.2, -2.0 / 3.0)), 1e-6, 0.5);
    if (!accepted) return true;
    here_ = std::move(there);
    rank_ = *rank;
    return true;
  }

  void heat() {
    taken_ = 0;
    ++cycle_;
    step_ = kFirstStep;
  }

  // Normal steps of all lengths, or of one.
  Design moved(const Design& design) {
    Design result = design;
    const int n = n_parameters(design);
    const int only = rng_.uniform() < 0.5 ? rng_.index(n) : -1;
    int at = 0;
    for (Placement& placement : result.modules) {
      const std::vector<ParameterRange>& ranges = problem_.library().type(placement.type).parameters;
      for (std::size_t i = 0; i < ranges.size(); ++i, ++at) {
        if (only >= 0 && at != only) continue;
        placement.parameters[static_cast<Eigen::Index>(i)] +=
            step_ * rng_.normal() * (ranges[i].upper - ranges[i].lower);
      }
    }
    clamp(problem_.library(), result);
    return result;
  }

  // Doubles with every cycle and begins anew after eight: 128 times the first price makes any promise worthless.
  [[nodiscard]] double penalty() const { return options_.penalty * std::exp2(cycle_ % 8); }

  [[nodiscard]] double bound_of(const Design& design) const { return problem_.optimism(design.types()).score; }

  // In points of the score; see the class.
  [[nodiscard]] double worth(const Design& design, const Rank& rank) const {
    constexpr double kForfeit = 0.01;  // what not being achieved costs by itself: as much as missing by one per cent
    using Level = Rank::Level;
    if (rank.level == Level::kAchieved) return rank.score;
    if (rank.level <= Level::kIncomplete) return -kInfinity;
    const double bound = bound_of(design);
    const double promise = std::isfinite(bound) ? bound : rank.score;
    const double missing = rank.level == Level::kNoPath ? 0.0 : -rank.within;
    return promise - penalty() * (kForfeit + missing);
  }

  static constexpr double kFirstStep = 0.1;  // share of the interval; arbitrary, it adapts

  const AnnealingOptions& options_;
  const DesignProblem& problem_;
  Rng rng_;
  bool begun_ = false;
  Design here_;
  Rank rank_;  // of here_; hopeless: not evaluated, anything is better
  int cycle_ = 0;
  int taken_ = 0;  // evaluations of this cycle
  int idle_ = 0;   // proposals in a row that were not worth an evaluation
  double step_ = kFirstStep;
};

void Walk::save(Archive& archive) const {
  put(archive, "anneal/rng", rng_);
  put(archive, "anneal/here", std::span{&here_, 1});
  archive.put("anneal/counts",
              std::array<std::int64_t, 5>{begun_, cycle_, taken_, idle_, static_cast<std::int64_t>(rank_.level)});
  archive.put("anneal/numbers", std::array<double, 3>{rank_.within, rank_.score, step_});
}

void Walk::restore(const Archive& archive) {
  rng_ = restored_rng(archive, "anneal/rng");
  const std::vector<Design> here = restored_designs(archive, "anneal/here", problem_.library());
  if (here.size() != 1) archive.fail("anneal/here", "does not hold one design");
  here_ = here.front();
  const std::vector<std::int64_t> counts = archive.integers("anneal/counts");
  const std::vector<double> numbers = archive.numbers("anneal/numbers");
  if (counts.size() != 5) archive.fail("anneal/counts", "does not hold 5 numbers");
  if (numbers.size() != 3) archive.fail("anneal/numbers", "does not hold 3 numbers");
  begun_ = counts[0] != 0;
  cycle_ = static_cast<int>(counts[1]);
  taken_ = static_cast<int>(counts[2]);
  idle_ = static_cast<int>(counts[3]);
  rank_ = restored_rank(archive, "anneal/counts", counts[4], numbers[0], numbers[1]);
  step_ = numbers[2];
}

}  // namespace

SimulatedAnnealing::SimulatedAnnealing(AnnealingOptions options) : options_{options} {
  const auto require = [](bool holds, const char* option, double value, const char* limit) {
    if (!holds) throw std::invalid_argument(fmt::format("anneal: {} is {}, not {}", option, value, limit));
  };
  require(options_.cycle >= 1, "cycle", options_.cycle, "at least 1");
  require(options_.cold > 0.0, "cold", options_.cold, "positive");
  require(options_.hot >= options_.cold && std::isfinite(options_.hot), "hot", options_.hot,
          "at least as much as cold");
  require(options_.structure >= 0.0 && options_.structure <= 1.0, "structure", options_.structure, "in [0, 1]");
  require(options_.penalty >= 0.0 && std::isfinite(options_.penalty), "penalty", options_.penalty, "at least 0");
}

std::unique_ptr<Search> SimulatedAnnealing::start(const DesignProblem& problem, Rng rng) const {
  return std::make_unique<Walk>(options_, problem, rng);
}

}  // namespace modsearch
