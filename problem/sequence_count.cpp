#include <fmt/format.h>

#include <map>
#include <modsearch/problem/sequence_count.hpp>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace modsearch {
namespace {

// Where a sequence can be within a pattern: (part, modules of that part so far). Several places at once where parts of
// one role meet, which is why sequences are counted by sets of places and not by ways.
using Place = std::pair<int, int>;
using Places = std::set<Place>;

// What may follow and how often it occurs: equal for all sequences with the same free end at the same places.
using Coupling = ModuleLibrary::Coupling;
using Tally = std::map<std::pair<Coupling, Places>, double>;

class Pattern {
 public:
  explicit Pattern(const std::vector<PatternPart>& parts) : parts_{parts} {
    constexpr int kMost = 64;  // modules of a problem
    for (const PatternPart& part : parts_) {
      if (part.least < 0 || part.least > part.most || part.most > kMost) {
        throw std::invalid_argument(fmt::format(
            "count_sequences: a part of {} to {} modules, not 0 <= least <= most <= {}", part.least, part.most, kMost));
      }
    }
  }

  [[nodiscard]] Places start() const { return closed({{0, 0}}); }
  [[nodiscard]] Places after(const Places& places, ModuleRole role) const {
    Places next;
    for (const auto& [part, count] : places) {
      if (part == size() || parts_[static_cast<std::size_t>(part)].role != role) continue;
      if (count < parts_[static_cast<std::size_t>(part)].most) next.insert({part, count + 1});
    }
    return closed(std::move(next));
  }
  [[nodiscard]] bool matched(const Places& places) const { return places.contains({size(), 0}); }

 private:
  [[nodiscard]] int size() const { return static_cast<int>(parts_.size()); }
  // With every place that is reached from these without a module.
  [[nodiscard]] Places closed(Places places) const {
    for (auto place = places.begin(); place != places.end(); ++place) {  // what is inserted comes later in the order
      const auto [part, count] = *place;
      if (part < size() && count >= parts_[static_cast<std::size_t>(part)].least) places.insert({part + 1, 0});
    }
    return places;
  }

  const std::vector<PatternPart>& parts_;
};

// Counts by number of modules until no sequence goes on; `after` is the connector rule.
template <typename After>
SequenceCount counted(const ModuleLibrary& library, const Pattern& pattern, const After& after) {
  SequenceCount count;
  Tally tally{{{library.base_coupling(), pattern.start()}, 1.0}};
  const auto add = [&](int last, const Tally::value_type& entry) {
    if (!pattern.matched(entry.first.second)) return;
    count.fitting += entry.second;
    // Whether a design is complete can be seen from its last module.
    const bool complete = last < 0 ? library.complete({}) : library.complete(std::span{&last, 1});
    if (complete) count.complete += entry.second;
  };
  for (const auto& entry : tally) add(-1, entry);
  while (!tally.empty()) {
    Tally longer;
    for (const auto& [state, ways] : tally) {
      for (int k = 0; k < library.n_types(); ++k) {
        const std::optional<Coupling> free = after(state.first, k);
        if (!free) continue;
        Places places = pattern.after(state.second, library.type(k).role());
        if (places.empty()) continue;
        const Tally::value_type step{{*free, std::move(places)}, ways};
        add(k, step);
        longer[step.first] += ways;
      }
    }
    tally = std::move(longer);
  }
  return count;
}

}  // namespace

SequenceCount count_sequences(const ModuleLibrary& library, int n) {
  if (n < 0) throw std::invalid_argument(fmt::format("count_sequences: {} modules, at least 0 are possible", n));
  const std::vector<double> ones(static_cast<std::size_t>(library.n_types()), 1.0);
  return count_designs(library, {}, n, ones);
}

SequenceCount count_designs(const ModuleLibrary& library, std::span<const int> prefix, int n,
                            std::span<const double> weights) {
  const int n_types = library.n_types();
  const int given = static_cast<int>(prefix.size());
  if (n < given || static_cast<int>(weights.size()) != n_types) {
    throw std::invalid_argument(fmt::format("count_designs: {} modules that begin with {}, {} weights for {} types", n,
                                            given, weights.size(), n_types));
  }
  Coupling free = library.base_coupling();
  double one = 1.0;
  for (const int k : prefix) {
    const std::optional<Coupling> next = library.coupling_after(free, k);
    if (!next) throw std::invalid_argument("count_designs: the modules of the prefix do not fit together");
    free = *next;
    one *= weights[static_cast<std::size_t>(k)];
  }
  SequenceCount count{.all = one, .fitting = one, .complete = library.complete(prefix) ? one : 0.0};
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::map<Coupling, double> ways{{free, one}};
  for (int i = given; i < n; ++i) {
    std::map<Coupling, double> longer;
    count = {.all = count.all * total};
    for (const auto& [coupling, before] : ways) {
      for (int k = 0; k < n_types; ++k) {
        const std::optional<Coupling> next = library.coupling_after(coupling, k);
        if (!next) continue;
        const double designs = before * weights[static_cast<std::size_t>(k)];
        longer[*next] += designs;
        count.fitting += designs;
        // Whether a design is complete can be seen from its last module.
        if (library.complete(std::span{&k, 1})) count.complete += designs;
      }
    }
    ways = std::move(longer);
  }
  return count;
}

SequenceCount count_sequences(const ModuleLibrary& library, const std::vector<PatternPart>& pattern) {
  const Pattern automaton{pattern};
  SequenceCount count =
      counted(library, automaton, [&](const Coupling& free, int k) { return library.coupling_after(free, k); });
  count.all = counted(library, automaton, [](const Coupling& free, int) { return std::optional{free}; }).fitting;
  return count;
}

}  // namespace modsearch
