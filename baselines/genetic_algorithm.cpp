#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <modsearch/baselines/design_moves_internal.hpp>
#include <modsearch/baselines/genetic_algorithm.hpp>
#include <modsearch/baselines/lexicographic.hpp>
#include <modsearch/baselines/memetic_polish.hpp>
#include <modsearch/baselines/random_search.hpp>
#include <set>
#include <stdexcept>

namespace modsearch {
namespace {

struct Individual {
  Design design;
  Rank rank;
};
using Species = std::vector<const Individual*>;  // the designs of one length

// Least clearances asked for by the first, second, .. polish of a sequence [m], as in per-sequence: a design that is
// lighter on paper and blocked in fact deserves another try with more room.
constexpr std::array<double, 4> kClearances{1e-6, 1e-3, 4e-3, 1.6e-2};

// 64 bits that tell designs apart (FNV-1a): in a million designs two are taken for one with a probability of 3e-8.
std::uint64_t fingerprint(const Design& design) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  const auto add = [&](std::uint64_t word) {
    for (int byte = 0; byte < 8; ++byte) hash = (hash ^ ((word >> (8 * byte)) & 0xff)) * 0x100000001b3ULL;
  };
  for (const Placement& placement : design.modules) {
    add(static_cast<std::uint64_t>(placement.type));
    for (const double value : placement.parameters) add(std::bit_cast<std::uint64_t>(value));
  }
  return hash;
}

class Evolution final : public Search {
 public:
  Evolution(const GeneticOptions& options, const DesignProblem& problem, Rng rng)
      : options_{options}, problem_{problem}, rng_{rng} {}

  // One generation.
  std::optional<SearchEnd> step(Meter& meter) override {
    if (generation_ == 0 && !meter.evaluate(problem_, Design{})) return SearchEnd{};
    if (std::optional<SearchEnd> end = pointless(meter, problem_)) return end;
    const std::size_t evaluated = seen_.size();
    std::vector<Individual> children;
    const std::vector<Species> all_species = species();
    for (int i = 0; i < options_.population; ++i) {
      if (!evaluate(meter, all_species.empty() ? random_design(problem_, rng_) : child(all_species), children))
        return SearchEnd{};
    }
    survive(meter, std::move(children));
    children.clear();
    if (!polish(meter, children)) return SearchEnd{};
    survive(meter, std::move(children));

    ++generation_;
    idle_ = seen_.size() == evaluated ? idle_ + 1 : 0;
    constexpr int kPatience = 20;  // generations; arbitrary: over a thousand children in vain
    if (idle_ < kPatience) return std::nullopt;
    return SearchEnd{StopReason::kExhausted,
                     fmt::format("{} generations, the last {} without a new design that could beat the best",
                                 generation_, kPatience),
                     {}};
  }

  void save(Archive& archive) const override;
  void restore(const Archive& archive) override;

 private:
  // Puts `design` among `born`, evaluated, unless it has been met before or is hopeless. False: time to stop.
  bool evaluate(Meter& meter, Design design, std::vector<Individual>& born) {
    mend(problem_, design, rng_);
    const std::uint64_t print = fingerprint(design);
    if (design.modules.empty() || seen_.contains(print)) return true;
    const std::optional<Rank> rank = evaluate_rank(meter, problem_, design);
    if (!rank) return false;
    if (rank->level == Rank::Level::kHopeless) return true;
    seen_.insert(print);
    born.push_back({std::move(design), *rank});
    return true;
  }

  Design child(const std::vector<Species>& all_species) {
    const Species& species = all_species[drawn(all_species.size())];
    const Design& parent = winner(species);
    Design result = rng_.uniform() < options_.crossover ? crossed(parent, winner(species)) : parent;
    if (rng_.uniform() < options_.structure) return changed_sequence(problem_, result, rng_);
    mutate(result);
    return result;
  }

  const Design& winner(const Species& species) {
    const Individual* best = species[drawn(species.size())];
    for (int i = 1; i < options_.tournament; ++i) {
      const Individual* other = species[drawn(species.size())];
      if (other->rank > best->rank) best = other;
    }
    return best->design;
  }

  // The first modules of `a` and the last of `b`; a module that both have at the same place lies on the line through
  // both.
  Design crossed(const Design& a, const Design& b) {
    constexpr double kBeyond = 0.25;  // how far beyond the parents: as in the source
    const double along = rng_.uniform(-kBeyond, 1.0 + kBeyond);
    const std::size_t cut = drawn(a.modules.size() + 1);
    Design result = a;
    for (std::size_t i = 0; i < a.modules.size(); ++i) {
      if (a.modules[i].type == b.modules[i].type) {
        result.modules[i].parameters += along * (b.modules[i].parameters - a.modules[i].parameters);
      } else if (i >= cut) {
        result.modules[i] = b.modules[i];
      }
    }
    clamp(problem_.library(), result);
    return result;
  }

  // On average one parameter takes a step, whose magnitude is uniform on a logarithmic scale.
  void mutate(Design& design) {
    const double probability = 1.0 / std::max(n_parameters(design), 1);
    for (Placement& placement : design.modules) {
      const std::vector<ParameterRange>& ranges = problem_.library().type(placement.type).parameters;
      for (std::size_t i = 0; i < ranges.size(); ++i) {
        if (rng_.uniform() >= probability) continue;
        const double size = options_.step * std::exp2(-options_.precision * rng_.uniform());
        const double sign = rng_.uniform() < 0.5 ? -1.0 : 1.0;
        placement.parameters[static_cast<Eigen::Index>(i)] += sign * size * (ranges[i].upper - ranges[i].lower);
      }
    }
    clamp(problem_.library(), design);
  }

  // Survivors in turn from each species, the best of each first. What cannot beat the best any more is dropped.
  void survive(const Meter& meter, std::vector<Individual> born) {
    const double to_beat = score_to_beat(meter);
    std::move(born.begin(), born.end(), std::back_inserter(population_));
    std::stable_sort(population_.begin(), population_.end(),
                     [](const Individual& a, const Individual& b) { return a.rank > b.rank; });
    std::map<std::size_t, int> places;
    std::vector<std::pair<int, Individual>> placed;
    for (Individual& individual : population_) {
      const bool best = placed.empty();
      if (!best && problem_.optimism(individual.design.types()).score <= to_beat) continue;
      const int place = places[individual.design.modules.size()]++;
      placed.emplace_back(place, std::move(individual));
    }
    std::stable_sort(placed.begin(), placed.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    placed.resize(std::min(placed.size(), static_cast<std::size_t>(options_.population)));
    population_.clear();
    for (auto& [place, individual] : placed) population_.push_back(std::move(individual));
  }

  // Polishes the foremost of the sequences that were polished least. False: time to stop.
  bool polish(Meter& meter, std::vector<Individual>& born) {
    for (int i = 0; i < options_.polish; ++i) {
      const Individual* chosen = nullptr;
      int least = static_cast<int>(kClearances.size());
      for (const Individual& individual : population_) {
        const auto found = polishes_.find(individual.design.types());
        const int done = found == polishes_.end() ? 0 : found->second;
        if (done >= least) continue;
        chosen = &individual;
        least = done;
      }
      if (!chosen) return true;
      const int n = polishes_[chosen->design.types()]++;
      std::optional<Design> design =
          polished(problem_, chosen->design, kClearances[static_cast<std::size_t>(n)], options_.inner, meter);
      if (meter.stopped()) return false;
      if (design && !evaluate(meter, *std::move(design), born)) return false;
    }
    return true;
  }

  [[nodiscard]] std::vector<Species> species() const {
    std::map<std::size_t, Species> by_length;
    for (const Individual& individual : population_) by_length[individual.design.modules.size()].push_back(&individual);
    std::vector<Species> result;
    for (auto& [length, members] : by_length) result.push_back(std::move(members));
    return result;
  }

  [[nodiscard]] std::size_t drawn(std::size_t n) { return static_cast<std::size_t>(rng_.index(static_cast<int>(n))); }

  const GeneticOptions& options_;
  const DesignProblem& problem_;
  Rng rng_;
  int generation_ = 0;
  int idle_ = 0;  // generations in a row that brought nothing new
  std::vector<Individual> population_;
  std::set<std::uint64_t> seen_;              // fingerprints of all designs evaluated
  std::map<std::vector<int>, int> polishes_;  // by type sequence
};

void Evolution::save(Archive& archive) const {
  put(archive, "ga/rng", rng_);
  archive.put("ga/generations", std::array<std::int64_t, 2>{generation_, idle_});
  std::vector<Design> designs;
  std::vector<std::int64_t> levels;
  std::vector<double> ranks;
  for (const Individual& individual : population_) {
    designs.push_back(individual.design);
    levels.push_back(static_cast<std::int64_t>(individual.rank.level));
    ranks.insert(ranks.end(), {individual.rank.within, individual.rank.score});
  }
  put(archive, "ga/population", designs);
  archive.put("ga/levels", std::span<const std::int64_t>{levels});
  archive.put("ga/ranks", std::span<const double>{ranks});
  const std::vector<std::uint64_t> seen(seen_.begin(), seen_.end());
  archive.put("ga/seen", std::span<const std::uint64_t>{seen});
  std::vector<std::int64_t> polishes;  // per sequence: times, number of types, types
  for (const auto& [types, times] : polishes_) {
    polishes.insert(polishes.end(), {times, static_cast<std::int64_t>(types.size())});
    polishes.insert(polishes.end(), types.begin(), types.end());
  }
  archive.put("ga/polishes", std::span<const std::int64_t>{polishes});
}

void Evolution::restore(const Archive& archive) {
  rng_ = restored_rng(archive, "ga/rng");
  const std::vector<std::int64_t> generations = archive.integers("ga/generations");
  if (generations.size() != 2) archive.fail("ga/generations", "does not hold 2 numbers");
  generation_ = static_cast<int>(generations[0]);
  idle_ = static_cast<int>(generations[1]);

  const std::vector<Design> designs = restored_designs(archive, "ga/population", problem_.library());
  const std::vector<std::int64_t> levels = archive.integers("ga/levels");
  const std::vector<double> ranks = archive.numbers("ga/ranks");
  if (levels.size() != designs.size()) archive.fail("ga/levels", "does not hold a number per design");
  if (ranks.size() != 2 * designs.size()) archive.fail("ga/ranks", "does not hold two numbers per design");
  population_.clear();
  for (std::size_t i = 0; i < designs.size(); ++i) {
    population_.push_back({designs[i], restored_rank(archive, "ga/levels", levels[i], ranks[2 * i], ranks[2 * i + 1])});
  }
  const std::vector<std::uint64_t> seen = archive.unsigned_integers("ga/seen");
  seen_ = {seen.begin(), seen.end()};

  polishes_.clear();
  const std::vector<std::int64_t> polishes = archive.integers("ga/polishes");
  for (std::size_t i = 0; i < polishes.size();) {
    if (i + 2 > polishes.size() || polishes[i + 1] < 0 ||
        static_cast<std::size_t>(polishes[i + 1]) > polishes.size() - i - 2) {
      archive.fail("ga/polishes", "ends within a sequence");
    }
    const auto first = polishes.begin() + static_cast<std::ptrdiff_t>(i) + 2;
    polishes_[std::vector<int>(first, first + polishes[i + 1])] = static_cast<int>(polishes[i]);
    i += 2 + static_cast<std::size_t>(polishes[i + 1]);
  }
}

void require(bool holds, const char* option, double value, const char* limit) {
  if (!holds) throw std::invalid_argument(fmt::format("ga: {} is {}, not {}", option, value, limit));
}

}  // namespace

GeneticAlgorithm::GeneticAlgorithm(GeneticOptions options) : options_{options} {
  require(options_.population >= 2, "population", options_.population, "at least 2");
  require(options_.tournament >= 1, "tournament", options_.tournament, "at least 1");
  require(options_.crossover >= 0.0 && options_.crossover <= 1.0, "crossover", options_.crossover, "in [0, 1]");
  require(options_.structure >= 0.0 && options_.structure <= 1.0, "structure", options_.structure, "in [0, 1]");
  require(options_.step > 0.0 && options_.step <= 1.0, "step", options_.step, "in (0, 1]");
  require(options_.precision >= 0 && options_.precision <= 50, "precision", options_.precision, "in [0, 50]");
  require(options_.polish >= 0, "polish", options_.polish, "at least 0");
}

std::unique_ptr<Search> GeneticAlgorithm::start(const DesignProblem& problem, Rng rng) const {
  return std::make_unique<Evolution>(options_, problem, rng);
}

}  // namespace modsearch
