#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <modsearch/baselines/eliminate.hpp>
#include <modsearch/baselines/lexicographic.hpp>
#include <modsearch/baselines/sequence_frontier.hpp>
#include <modsearch/problem/sequence_count.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr double kImpossible = -std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-9;  // scores are sums of a few numbers up to some hundreds

// The values of one parameter, and the designs of a type sequence by number: the last parameter counts fastest.
class Grid {
 public:
  Grid(const ModuleLibrary& library, int points) : library_{library}, points_{points} {}

  [[nodiscard]] double designs_of_type(int k) const { return std::pow(points_, library_.type(k).n_parameters()); }
  [[nodiscard]] double size(std::span<const int> types) const {
    double product = 1.0;
    for (const int k : types) product *= designs_of_type(k);
    return product;
  }
  [[nodiscard]] Design design(std::span<const int> types, std::int64_t number) const {
    const ParameterBox box = parameter_box(library_, types);
    Eigen::VectorXd x(box.lower.size());
    for (Eigen::Index i = x.size() - 1; i >= 0; --i) {
      const double share = points_ == 1 ? 0.5 : static_cast<double>(number % points_) / (points_ - 1);
      x[i] = box.lower[i] + share * (box.upper[i] - box.lower[i]);
      number /= points_;
    }
    return make_design(library_, types, x);
  }

 private:
  const ModuleLibrary& library_;
  int points_;
};

class Elimination final : public Search {
 public:
  Elimination(const DesignProblem& problem, const EliminateOptions& options)
      : problem_{problem},
        grid_{problem.library(), options.grid},
        stages_{problem.stages()},
        frontier_{problem, 1'000'000, weights()} {}

  std::optional<SearchEnd> step(Meter& meter) override {
    if (!begun_) {
      if (!meter.evaluate(problem_, Design{})) return end(meter);
      begun_ = true;
    }
    if (types_.empty()) {
      std::optional<SequenceFrontier::Sequence> next = frontier_.next(meter);
      if (!next) return frontier_.exhausted() ? std::optional{end(meter)} : std::nullopt;
      types_ = std::move(next->types);
      bound_ = next->bound;
      number_ = 0;
    }
    constexpr int kBatch = 64;  // designs between two places where the search can be taken up: arbitrary
    for (int i = 0; i < kBatch && static_cast<double>(number_) < grid_.size(types_); ++i) {
      if (score_to_beat(meter) >= bound_) break;
      if (!pass(grid_.design(types_, number_), meter)) return end(meter);
      ++number_;
    }
    if (score_to_beat(meter) >= bound_ || static_cast<double>(number_) >= grid_.size(types_)) types_.clear();
    return std::nullopt;
  }

  void save(Archive& archive) const override;
  void restore(const Archive& archive) override;

 private:
  [[nodiscard]] std::vector<double> weights() const {
    std::vector<double> designs;
    for (int k = 0; k < problem_.library().n_types(); ++k) designs.push_back(grid_.designs_of_type(k));
    return designs;
  }

  // Through the stages until it fails one. False: time to stop.
  [[nodiscard]] bool pass(const Design& design, Meter& meter) {
    for (const Fidelity stage : stages_) {
      const double to_beat = score_to_beat(meter);
      const std::optional<Evaluation> evaluation = meter.evaluate(problem_, design, stage);
      if (!evaluation) return false;
      if (!evaluation->attempt.achieved) {
        ++failed_[evaluation->attempt.why];
        if (!is_settled(*evaluation)) open_bound_ = std::max(open_bound_, bound_);
        return true;
      }
      if (evaluation->score <= to_beat) {
        ++outscored_;
        return true;
      }
    }
    ++achieved_;
    return true;
  }

  [[nodiscard]] std::vector<Tally> tallies() const;
  [[nodiscard]] SearchEnd end(const Meter& meter) const;

  const DesignProblem& problem_;
  Grid grid_;
  std::vector<Fidelity> stages_;
  SequenceFrontier frontier_;
  bool begun_ = false;
  std::vector<int> types_;  // whose designs are passing; empty: none
  double bound_ = 0.0;      // of these
  std::int64_t number_ = 0;
  std::int64_t outscored_ = 0;
  std::int64_t achieved_ = 0;
  std::map<Failure, std::int64_t> failed_;  // in the order of the stages
  double open_bound_ = kImpossible;         // greatest bound of the designs of which nothing is proved
};

std::vector<Tally> Elimination::tallies() const {
  SequenceCount all;
  const std::vector<double> designs = weights();
  for (int n = 1; n < problem_.max_modules(); ++n) {
    const SequenceCount count = count_designs(problem_.library(), {}, n, designs);
    all.all += count.all;
    all.fitting += count.fitting;
    all.complete += count.complete;
  }
  double rest = all.complete - frontier_.left_out() - static_cast<double>(outscored_ + achieved_);
  for (const auto& [why, count] : failed_) rest -= static_cast<double>(count);
  std::vector<Tally> result{{"designs", all.all},
                            {"connectors", all.all - all.fitting},
                            {"completeness", all.fitting - all.complete},
                            {"reach", frontier_.left_out()},
                            {"score bound", static_cast<double>(outscored_)}};
  // What was never looked at: behind the best, if the search came to its end.
  (frontier_.exhausted() && types_.empty() ? result.back().count
                                           : result.emplace_back(Tally{"not reached", 0.0}).count) += rest;
  for (const auto& [why, count] : failed_) result.push_back({std::string{name(why)}, static_cast<double>(count)});
  result.push_back({"achieved", static_cast<double>(achieved_)});
  return result;
}

SearchEnd Elimination::end(const Meter& meter) const {
  SearchEnd end;
  end.tallies = tallies();
  const bool finished = begun_ && frontier_.exhausted() && types_.empty();
  std::string removed;
  for (const Tally& tally : end.tallies) {
    if (tally.count > 0.0) removed += fmt::format("{}{} {:.15g}", removed.empty() ? "" : ", ", tally.what, tally.count);
  }
  end.reason = removed;
  const bool discrete = problem_.library().max_parameters() == 0;
  if (!finished) return end;
  const double best = score_to_beat(meter);
  const bool none_evaluated = failed_.empty() && achieved_ == 0 && outscored_ == 0;
  if (best == kImpossible && none_evaluated) {
    end.reason = frontier_.impossible().empty() ? "no module may be attached" : frontier_.impossible();
    end.stop = StopReason::kUnreachable;
    end.bound = Bound{kImpossible, "reach"};
  } else if (discrete && open_bound_ > best + kRounding) {
    end.reason = fmt::format("{}; {}", removed, nothing_proved(meter));
    if (std::isfinite(open_bound_)) end.bound = Bound{open_bound_, "modules, mass by reach"};
  } else if (discrete) {
    end.stop = best > kImpossible ? StopReason::kOptimal : StopReason::kUnreachable;
    end.bound = Bound{best, "every design that could score more was tested"};
    if (best == kImpossible) end.reason = "none passes: " + removed;
  } else {
    end.reason = "the best of the grid, nothing is proved between its points: " + removed;
  }
  return end;
}

void Elimination::save(Archive& archive) const {
  frontier_.save(archive);
  std::vector<std::int64_t> numbers{begun_ ? 1 : 0, number_, outscored_, achieved_};
  for (const auto& [why, count] : failed_) numbers.insert(numbers.end(), {static_cast<std::int64_t>(why), count});
  archive.put("elimination/counts", std::span<const std::int64_t>{numbers});
  archive.put("elimination/types",
              std::span<const std::int64_t>{std::vector<std::int64_t>(types_.begin(), types_.end())});
  archive.put_number("elimination/bound", bound_);
  archive.put_number("elimination/open bound", open_bound_);
}

void Elimination::restore(const Archive& archive) {
  frontier_.restore(archive);
  const std::vector<std::int64_t> numbers = archive.integers("elimination/counts");
  if (numbers.size() < 4 || numbers.size() % 2 != 0) archive.fail("elimination/counts", "is not a list of counts");
  begun_ = numbers[0] != 0;
  number_ = numbers[1];
  outscored_ = numbers[2];
  achieved_ = numbers[3];
  failed_.clear();
  for (std::size_t i = 4; i < numbers.size(); i += 2) failed_[static_cast<Failure>(numbers[i])] = numbers[i + 1];
  types_.clear();
  for (const std::int64_t k : archive.integers("elimination/types")) {
    if (k < 0 || k >= problem_.library().n_types()) archive.fail("elimination/types", fmt::format("holds type {}", k));
    types_.push_back(static_cast<int>(k));
  }
  bound_ = archive.number("elimination/bound");
  // A checkpoint of an earlier version does not tell which of the failures were proofs.
  const double unknown = failed_.empty() ? kImpossible : std::numeric_limits<double>::infinity();
  open_bound_ = archive.has("elimination/open bound") ? archive.number("elimination/open bound") : unknown;
}

}  // namespace

Eliminate::Eliminate(EliminateOptions options) : options_{options} {
  if (options_.grid < 1 || options_.grid > 1000) {
    throw std::invalid_argument(fmt::format("eliminate: grid is {}, not in [1, 1000]", options_.grid));
  }
}

std::unique_ptr<Search> Eliminate::start(const DesignProblem& problem, Rng) const {
  return std::make_unique<Elimination>(problem, options_);
}

}  // namespace modsearch
