#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <modsearch/baselines/cat_cma.hpp>
#include <modsearch/baselines/cma_es.hpp>
#include <modsearch/baselines/lexicographic.hpp>
#include <numeric>
#include <stdexcept>

namespace modsearch {
namespace {

// The interval [0, 1] unrolled over the line, back and forth: the identity within it, and steep everywhere.
double folded(double value) {
  const double within = std::fabs(std::fmod(value, 2.0));
  return within <= 1.0 ? within : 2.0 - within;
}

class Restarts final : public Search {
 public:
  Restarts(const CmaEsOptions& options, const DesignProblem& problem, Rng rng)
      : options_{options}, problem_{problem}, rng_{rng} {}

  // One generation, or the choice of what to search next.
  std::optional<SearchEnd> step(Meter& meter) override {
    if (!begun_ && !meter.evaluate(problem_, Design{})) return SearchEnd{};
    begun_ = true;
    if (std::optional<SearchEnd> end = pointless(meter, problem_)) return end;
    if (!cma_) return start_next(meter);

    std::vector<std::pair<Rank, MixedPoint>> points;
    for (int i = 0; i < cma_->population(); ++i) {
      MixedPoint point = cma_->ask(rng_, [&](std::span<const int> chosen) { return allowed(chosen); });
      const std::optional<Rank> rank = evaluate_rank(meter, problem_, design(point));
      if (!rank) return SearchEnd{};
      points.emplace_back(*rank, std::move(point));
    }
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<MixedPoint> ranked;
    for (auto& [rank, point] : points) ranked.push_back(std::move(point));
    cma_->tell(ranked);
    if (converged(points.front().first)) cma_.reset();
    return std::nullopt;
  }

  void save(Archive& archive) const override;
  void restore(const Archive& archive) override;

 private:
  [[nodiscard]] bool padded() const { return options_.space == CmaEsOptions::Space::kPadded; }
  [[nodiscard]] int empty() const { return problem_.library().n_types(); }  // category of an empty slot

  // Begins the search of the next number of modules that can beat the best; when the round is over, a new round.
  std::optional<SearchEnd> start_next(const Meter& meter) {
    if (waiting_.empty()) {
      if (round_ > 0 && !useful_) {
        return SearchEnd{
            StopReason::kExhausted, fmt::format("{} rounds, the last without a design worth evaluating", round_), {}};
      }
      ++round_;
      useful_ = false;
      waiting_ = lengths();
    }
    slots_ = waiting_.front();
    waiting_.pop_front();
    if (!padded() && problem_.optimism_of_length(slots_).score <= score_to_beat(meter)) return std::nullopt;
    CatCmaStart start = beginning();
    if (round_ > 1) {
      for (double& value : start.mean) value = rng_.uniform();
    }
    cma_.emplace(start);
    best_ = Rank{};
    stale_ = 0;
    return std::nullopt;
  }

  // Numbers of slots to be searched, in order of their bound; fewer first among equals.
  [[nodiscard]] std::deque<int> lengths() const {
    if (padded()) return {problem_.max_modules() - 1};
    std::deque<int> result(static_cast<std::size_t>(problem_.max_modules() - 1));
    std::iota(result.begin(), result.end(), 1);
    std::stable_sort(result.begin(), result.end(), [&](int a, int b) {
      return problem_.optimism_of_length(a).score > problem_.optimism_of_length(b).score;
    });
    return result;
  }

  [[nodiscard]] CatCmaStart beginning() const {
    CatCmaStart start;
    start.mean = Eigen::VectorXd::Constant(slots_ * problem_.library().max_parameters(), 0.5);
    start.sigma = options_.sigma;
    start.categories.assign(static_cast<std::size_t>(slots_), problem_.library().n_types() + (padded() ? 1 : 0));
    const auto variables = static_cast<double>(start.mean.size() + slots_);
    const double first = options_.population > 0 ? options_.population : 4.0 + std::floor(3.0 * std::log(variables));
    constexpr double kMost = 10'000.0;  // some generations must fit into any budget
    start.population = static_cast<int>(std::min(kMost, first * std::pow(options_.growth, round_ - 1)));
    return start;
  }

  [[nodiscard]] std::vector<int> allowed(std::span<const int> chosen) const {
    std::vector<int> types(chosen.begin(), chosen.end());
    std::erase(types, empty());
    // A prefix that nothing fits any more goes on with anything: design() leaves it out.
    std::vector<int> result = fits(types) ? problem_.successors(types) : std::vector<int>{};
    if (padded()) result.push_back(empty());
    return result;
  }

  [[nodiscard]] bool fits(std::span<const int> types) const { return problem_.library().fits_together(types); }

  [[nodiscard]] Design design(const MixedPoint& point) const {
    Design result;
    std::vector<int> types;
    const int stride = problem_.library().max_parameters();
    for (int slot = 0; slot < slots_; ++slot) {
      const int k = point.categories[static_cast<std::size_t>(slot)];
      if (k == empty()) continue;
      const std::vector<int> successors = problem_.successors(types);
      if (std::find(successors.begin(), successors.end(), k) == successors.end()) break;
      const std::vector<ParameterRange>& ranges = problem_.library().type(k).parameters;
      Placement placement{k, Parameters(static_cast<Eigen::Index>(ranges.size()))};
      for (std::size_t i = 0; i < ranges.size(); ++i) {
        const double share = folded(point.x[slot * stride + static_cast<int>(i)]);
        placement.parameters[static_cast<Eigen::Index>(i)] =
            std::clamp(ranges[i].lower + share * (ranges[i].upper - ranges[i].lower), ranges[i].lower, ranges[i].upper);
      }
      result.modules.push_back(std::move(placement));
      types.push_back(k);
    }
    return result;
  }

  // Narrow enough, degenerate, without hope, or no better for long (Hansen 2016, appendix B.3: 10 + 30 n / lambda).
  [[nodiscard]] bool converged(const Rank& best) {
    if (best.level != Rank::Level::kHopeless) useful_ = true;
    stale_ = best > best_ ? 0 : stale_ + 1;
    if (best > best_) best_ = best;
    const int patience =
        10 + static_cast<int>(30.0 * static_cast<double>(cma_->mean().size() + slots_) / cma_->population());
    const bool narrow = cma_->mean().size() > 0 && cma_->spread() < options_.least_sigma;
    return narrow || cma_->degenerate() || best.level == Rank::Level::kHopeless || stale_ >= patience;
  }

  const CmaEsOptions& options_;
  const DesignProblem& problem_;
  Rng rng_;
  bool begun_ = false;
  int round_ = 0;
  bool useful_ = false;      // something was evaluated in this round
  std::deque<int> waiting_;  // numbers of slots still to be searched in this round
  int slots_ = 0;            // of the search under way
  std::optional<CatCma> cma_;
  Rank best_;      // of the search under way
  int stale_ = 0;  // generations since it last improved
};

void Restarts::save(Archive& archive) const {
  put(archive, "cmaes/rng", rng_);
  archive.put("cmaes/counts", std::array<std::int64_t, 7>{begun_, round_, useful_, slots_, cma_.has_value(), stale_,
                                                          static_cast<std::int64_t>(best_.level)});
  archive.put("cmaes/best", std::array<double, 2>{best_.within, best_.score});
  const std::vector<std::int64_t> waiting(waiting_.begin(), waiting_.end());
  archive.put("cmaes/waiting", std::span<const std::int64_t>{waiting});
  if (cma_) cma_->save(archive, "cmaes/distribution");
}

void Restarts::restore(const Archive& archive) {
  rng_ = restored_rng(archive, "cmaes/rng");
  const std::vector<std::int64_t> counts = archive.integers("cmaes/counts");
  const std::vector<double> best = archive.numbers("cmaes/best");
  if (counts.size() != 7) archive.fail("cmaes/counts", "does not hold 7 numbers");
  if (best.size() != 2) archive.fail("cmaes/best", "does not hold 2 numbers");
  begun_ = counts[0] != 0;
  round_ = static_cast<int>(counts[1]);
  useful_ = counts[2] != 0;
  slots_ = static_cast<int>(counts[3]);
  if (slots_ < 0 || slots_ >= problem_.max_modules()) {
    archive.fail("cmaes/counts", fmt::format("has {} slots (limit: {})", slots_, problem_.max_modules() - 1));
  }
  stale_ = static_cast<int>(counts[5]);
  best_ = restored_rank(archive, "cmaes/counts", counts[6], best[0], best[1]);
  const std::vector<std::int64_t> waiting = archive.integers("cmaes/waiting");
  waiting_.assign(waiting.begin(), waiting.end());
  cma_.reset();
  if (counts[4] == 0) return;
  cma_.emplace(beginning());
  cma_->restore(archive, "cmaes/distribution");
}

}  // namespace

std::string_view name(CmaEsOptions::Space space) {
  switch (space) {
    case CmaEsOptions::Space::kLengths:
      return "lengths";
    case CmaEsOptions::Space::kPadded:
      return "padded";
  }
  throw std::invalid_argument("name: no such CmaEsOptions::Space");
}

std::optional<CmaEsOptions::Space> space_from_name(std::string_view text) {
  for (const auto space : {CmaEsOptions::Space::kLengths, CmaEsOptions::Space::kPadded}) {
    if (name(space) == text) return space;
  }
  return std::nullopt;
}

CmaEs::CmaEs(CmaEsOptions options) : options_{options} {
  const auto require = [](bool holds, const char* option, double value, const char* limit) {
    if (!holds) throw std::invalid_argument(fmt::format("cmaes: {} is {}, not {}", option, value, limit));
  };
  require(options_.population == 0 || options_.population >= 4, "population", options_.population, "0 or at least 4");
  require(options_.growth >= 1.0 && options_.growth <= 100.0, "growth", options_.growth, "in [1, 100]");
  require(options_.sigma > 0.0 && options_.sigma <= 10.0, "sigma", options_.sigma, "in (0, 10]");
  require(options_.least_sigma > 0.0, "least_sigma", options_.least_sigma, "positive");
}

std::unique_ptr<Search> CmaEs::start(const DesignProblem& problem, Rng rng) const {
  return std::make_unique<Restarts>(options_, problem, rng);
}

}  // namespace modsearch
